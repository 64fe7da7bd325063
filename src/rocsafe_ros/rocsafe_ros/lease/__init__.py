# SPDX-License-Identifier: Apache-2.0
"""Who may command a vehicle, until when."""

# SPDX-License-Identifier: Apache-2.0
"""The command that plans the drive of a ground vehicle."""

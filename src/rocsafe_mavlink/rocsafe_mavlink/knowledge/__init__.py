# SPDX-License-Identifier: Apache-2.0
"""What is known of a vehicle from its messages."""

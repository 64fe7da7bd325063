# SPDX-License-Identifier: Apache-2.0
"""Limits that the scenario file and the command line share."""

LARGEST_SEED = 2**31 - 1
# Simulated seconds a second.
LARGEST_SPEED = 1000.0
LARGEST_HEIGHT_M = 500.0
LARGEST_FLEET = 300
LARGEST_BUDGET_S = 3600.0

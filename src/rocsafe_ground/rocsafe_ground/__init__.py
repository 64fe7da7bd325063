# SPDX-License-Identifier: Apache-2.0
"""Routes of a ground vehicle to evidence points, within budgets of dose and battery."""

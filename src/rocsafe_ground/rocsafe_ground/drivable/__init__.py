# SPDX-License-Identifier: Apache-2.0
"""Where a vehicle can drive, and how fast, from the products of a survey."""

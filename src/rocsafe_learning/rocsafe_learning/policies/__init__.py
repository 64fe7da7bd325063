# SPDX-License-Identifier: Apache-2.0
"""Policies to compare with: lawn-mower, information gain, random, and a linear one."""

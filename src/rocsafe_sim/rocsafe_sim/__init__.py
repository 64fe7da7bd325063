# SPDX-License-Identifier: Apache-2.0
"""Simulated world and vehicles of ROCSAFE."""

# SPDX-License-Identifier: Apache-2.0
"""A simulated vehicle: its orders, collisions, record and journal."""

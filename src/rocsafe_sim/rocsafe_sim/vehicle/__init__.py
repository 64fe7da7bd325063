# SPDX-License-Identifier: Apache-2.0
"""A simulated vehicle without sensors: commands, collisions, record and journal."""

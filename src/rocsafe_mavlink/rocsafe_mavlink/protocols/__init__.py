# SPDX-License-Identifier: Apache-2.0
"""The sub-protocols of MAVLink: commands, missions, message rates."""

# SPDX-License-Identifier: Apache-2.0
"""Checks of a vehicle and its plan before a flight, each with what was found."""

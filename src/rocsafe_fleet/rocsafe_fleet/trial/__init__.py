# SPDX-License-Identifier: Apache-2.0
"""Fleets in simulated time: radio, vehicles, trials."""

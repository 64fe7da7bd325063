# SPDX-License-Identifier: Apache-2.0
"""The flight of a vehicle as a function of time."""

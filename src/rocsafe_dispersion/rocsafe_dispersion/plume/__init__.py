# SPDX-License-Identifier: Apache-2.0
"""Transport of gas and particles: plume, puffs, filaments, deposition."""

# SPDX-License-Identifier: Apache-2.0
"""Rays through a scene: what stands where, shields what, and how high the ground is."""

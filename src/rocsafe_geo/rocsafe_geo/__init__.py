# SPDX-License-Identifier: Apache-2.0
"""Positions, frames, areas, motion and camera geometry for ROCSAFE."""

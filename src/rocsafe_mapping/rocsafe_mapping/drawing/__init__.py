# SPDX-License-Identifier: Apache-2.0
"""Aligned photographs drawn as one map, tile by tile. Pure."""

# SPDX-License-Identifier: Apache-2.0
"""Terrain, its picture and pictures of flat ground."""

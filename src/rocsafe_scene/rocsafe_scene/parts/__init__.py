# SPDX-License-Identifier: Apache-2.0
"""Makers of meshes: vehicles, buildings, plants, people, small objects."""

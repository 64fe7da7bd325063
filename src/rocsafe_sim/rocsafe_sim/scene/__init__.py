# SPDX-License-Identifier: Apache-2.0
"""The virtual environment as data: terrain, meshes, labels, materials, rays. No engine."""

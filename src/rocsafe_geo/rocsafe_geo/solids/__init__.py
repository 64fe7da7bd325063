# SPDX-License-Identifier: Apache-2.0
"""The things of a scene as closed solids of triangles, and the file that holds them."""

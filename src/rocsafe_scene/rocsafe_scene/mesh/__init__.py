# SPDX-License-Identifier: Apache-2.0
"""Triangles, surfaces, classes and shapes."""

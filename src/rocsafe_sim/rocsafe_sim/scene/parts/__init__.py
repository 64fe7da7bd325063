# SPDX-License-Identifier: Apache-2.0
"""Meshes of things, each made from numbers and a generator."""

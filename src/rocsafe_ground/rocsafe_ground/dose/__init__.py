# SPDX-License-Identifier: Apache-2.0
"""Dose rates on the grid of a route, and how sure they are."""

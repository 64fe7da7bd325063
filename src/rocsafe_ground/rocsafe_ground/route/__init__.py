# SPDX-License-Identifier: Apache-2.0
"""The fastest way between two cells of a grid within a budget of dose, with a proof."""

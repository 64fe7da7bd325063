# SPDX-License-Identifier: Apache-2.0
"""Sources from a grid of probabilities."""

# SPDX-License-Identifier: Apache-2.0
"""Sources from readings on a grid of beliefs."""

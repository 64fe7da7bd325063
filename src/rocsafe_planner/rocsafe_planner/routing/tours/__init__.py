# SPDX-License-Identifier: Apache-2.0
"""Tours over all points, and how they are shared between vehicles: methods without a search."""

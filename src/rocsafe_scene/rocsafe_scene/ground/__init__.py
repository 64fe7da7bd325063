# SPDX-License-Identifier: Apache-2.0
"""The ground: heights, maps of colours and classes, orthophotos."""

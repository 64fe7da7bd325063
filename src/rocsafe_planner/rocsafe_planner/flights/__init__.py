# SPDX-License-Identifier: Apache-2.0
"""What vehicles fly, from the order of their viewpoints: routes, tracks, distances in the air."""

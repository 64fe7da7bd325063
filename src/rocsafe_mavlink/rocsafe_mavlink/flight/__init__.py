# SPDX-License-Identifier: Apache-2.0
"""A flight of a real vehicle, from its checks to its end."""

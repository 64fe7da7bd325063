# SPDX-License-Identifier: Apache-2.0
"""The game engine that draws a scene."""

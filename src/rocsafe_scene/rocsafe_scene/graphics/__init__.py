# SPDX-License-Identifier: Apache-2.0
"""Access to Panda3D, without knowledge of scenes: pipes, buffers, lenses, uploads."""

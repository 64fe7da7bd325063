# SPDX-License-Identifier: Apache-2.0
"""Use of Panda3D that knows nothing of scenes: pipes, buffers, lenses, uploads."""

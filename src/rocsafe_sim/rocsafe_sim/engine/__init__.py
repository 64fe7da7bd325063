# SPDX-License-Identifier: Apache-2.0
"""Panda3D behind the camera: the only place that imports it."""

# SPDX-License-Identifier: Apache-2.0
"""Scenes and how cameras see them: scene files, engine, flat ground, optics. No ROS."""

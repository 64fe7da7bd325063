# SPDX-License-Identifier: Apache-2.0
"""Environments for learning: searching a source with one drone or several, and surveying.

They need neither ROS nor a screen. Importing `rocsafe_learning.registration` needs gymnasium.
"""

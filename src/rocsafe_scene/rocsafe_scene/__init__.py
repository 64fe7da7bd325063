# SPDX-License-Identifier: Apache-2.0
"""What there is to see, and how a camera sees it: scenes, engine, optics. No ROS."""

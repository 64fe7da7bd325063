# SPDX-License-Identifier: Apache-2.0
"""Others in the ROS domain: who is there, what they hear and which interfaces they use."""

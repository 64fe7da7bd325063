# SPDX-License-Identifier: Apache-2.0
"""What a real vehicle is asked and tells over ROS 2."""

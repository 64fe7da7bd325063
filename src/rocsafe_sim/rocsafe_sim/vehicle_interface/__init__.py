# SPDX-License-Identifier: Apache-2.0
"""What a simulated vehicle is asked and tells over ROS 2."""

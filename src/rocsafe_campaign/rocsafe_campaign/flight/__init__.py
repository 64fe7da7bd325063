# SPDX-License-Identifier: Apache-2.0
"""A mission without ROS: plan, flight, readings, sources."""

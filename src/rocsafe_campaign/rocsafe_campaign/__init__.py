# SPDX-License-Identifier: Apache-2.0
"""Campaigns: many simulated missions, without ROS or with whole processes."""

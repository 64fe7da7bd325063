# SPDX-License-Identifier: Apache-2.0
"""Makes a checkout ready to fly: virtual environment, ROS 2, packages built, commands.

Uses the standard library only, because it runs before anything is installed. Nothing outside the
checkout is written. Every stage leaves a record when it is complete, so that a set-up that was
interrupted at any moment is found out and its half-made stage is made again.
"""

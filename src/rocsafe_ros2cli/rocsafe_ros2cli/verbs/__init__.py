# SPDX-License-Identifier: Apache-2.0
"""The commands of `ros2`, a module each, and what they need of their own."""

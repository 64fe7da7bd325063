# SPDX-License-Identifier: Apache-2.0
"""A simulated vehicle with its sensors, cameras and files."""

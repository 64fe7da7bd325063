# SPDX-License-Identifier: Apache-2.0
"""A simulated ground vehicle: chassis, steering, way back, and its drive."""

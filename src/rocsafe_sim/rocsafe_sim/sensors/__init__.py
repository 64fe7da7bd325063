# SPDX-License-Identifier: Apache-2.0
"""Sensors of motion, air, field and distance of a simulated vehicle, by stated error models."""

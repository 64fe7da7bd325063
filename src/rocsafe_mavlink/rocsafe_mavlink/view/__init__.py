# SPDX-License-Identifier: Apache-2.0
"""Simulated vehicles as a ground station sees them: shown, never commanded."""

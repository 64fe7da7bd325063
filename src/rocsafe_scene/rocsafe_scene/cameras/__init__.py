# SPDX-License-Identifier: Apache-2.0
"""Cameras: over a flat picture, or in the engine."""

# SPDX-License-Identifier: Apache-2.0
"""Lens, shutter and sensor of a camera."""

# SPDX-License-Identifier: Apache-2.0
"""Photographs: pose, Exif, labels."""

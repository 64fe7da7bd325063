# SPDX-License-Identifier: Apache-2.0
"""Photographs with their pose, and files written whole."""

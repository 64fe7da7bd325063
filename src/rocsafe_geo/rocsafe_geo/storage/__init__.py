# SPDX-License-Identifier: Apache-2.0
"""Photographs with their pose, files written atomically, settings read from YAML."""

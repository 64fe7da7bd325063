# SPDX-License-Identifier: Apache-2.0
"""Scenes: description, file, building, caches."""

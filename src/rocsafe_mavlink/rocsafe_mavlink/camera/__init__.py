# SPDX-License-Identifier: Apache-2.0
"""Photographs of a real vehicle."""

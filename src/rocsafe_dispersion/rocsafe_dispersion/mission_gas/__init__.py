# SPDX-License-Identifier: Apache-2.0
"""Readings of a running flight, and what they say of releases."""

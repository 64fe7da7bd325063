# SPDX-License-Identifier: Apache-2.0
"""Readings of real detectors: lines of text from a port, with time and place."""

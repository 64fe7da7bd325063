# SPDX-License-Identifier: Apache-2.0
"""Detectors of gas and particles."""

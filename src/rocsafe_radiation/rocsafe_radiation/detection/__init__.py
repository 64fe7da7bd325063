# SPDX-License-Identifier: Apache-2.0
"""Detectors, counting and dose."""

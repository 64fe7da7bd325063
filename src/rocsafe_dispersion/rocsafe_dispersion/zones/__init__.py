# SPDX-License-Identifier: Apache-2.0
"""Threat zones and toxic load."""

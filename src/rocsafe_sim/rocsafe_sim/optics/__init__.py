# SPDX-License-Identifier: Apache-2.0
"""Lens and sensor: what makes a photograph of a drawn picture."""

# SPDX-License-Identifier: Apache-2.0
"""Cameras and gimbals that a vehicle carries."""

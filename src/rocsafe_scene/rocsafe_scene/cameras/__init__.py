# SPDX-License-Identifier: Apache-2.0
"""Cameras over flat ground and in scenes of the engine."""

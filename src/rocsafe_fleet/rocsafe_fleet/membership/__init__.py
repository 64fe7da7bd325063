# SPDX-License-Identifier: Apache-2.0
"""Vehicles that are heard."""

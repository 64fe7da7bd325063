# SPDX-License-Identifier: Apache-2.0
"""Photons, nuclides, transmission, sources and their dose rate."""

# SPDX-License-Identifier: Apache-2.0
"""Gamma dose-rate field and detectors of ROCSAFE."""

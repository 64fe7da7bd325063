# SPDX-License-Identifier: Apache-2.0
"""Regions with holes, and the files that hold them."""

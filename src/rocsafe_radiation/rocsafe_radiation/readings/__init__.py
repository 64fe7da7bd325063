# SPDX-License-Identifier: Apache-2.0
"""Readings of a survey and the files that hold them."""

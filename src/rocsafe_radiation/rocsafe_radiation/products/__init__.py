# SPDX-License-Identifier: Apache-2.0
"""Dose map, cordons and files of an assessment."""

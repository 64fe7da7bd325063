# SPDX-License-Identifier: Apache-2.0
"""Errors of data sets."""


class DatasetError(Exception):
    """A data set cannot be made or continued; one line says why."""

# SPDX-License-Identifier: Apache-2.0
"""Failures of making a data set that a caller may want to treat."""


class DatasetError(Exception):
    """A data set cannot be made or continued; one line says why."""

# SPDX-License-Identifier: Apache-2.0
"""Errors of mapping."""


class MappingError(Exception):
    """Base of all errors of this package."""


class StoreError(MappingError):
    """The image store cannot be used or written: nothing was acknowledged, try again later."""


class PlacementError(MappingError):
    """A photograph cannot be placed on the map, now or later."""

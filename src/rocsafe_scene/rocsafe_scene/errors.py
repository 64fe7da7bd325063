# SPDX-License-Identifier: Apache-2.0
"""Errors of scenes and cameras."""


class ViewError(Exception):
    """Base of all failures of this package."""


class GroundError(ViewError):
    """The ground picture cannot be read, or does not show what is asked for."""


class SceneError(ViewError):
    """A scene cannot be read or built; one line says what is wrong."""


class EngineError(ViewError):
    """The camera's engine cannot start or did not deliver a picture."""

# SPDX-License-Identifier: Apache-2.0
"""Off-screen buffers, and the check that one thread uses them."""

import threading
from typing import Any

import numpy as np
from numpy.typing import NDArray
from panda3d import core

from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_scene.errors import EngineError
from rocsafe_scene.graphics.pipe import Pipe


class OneThread:
    """Remembers the thread that made it: objects of Panda3D must not be used from another."""

    def __init__(self) -> None:
        self._thread = threading.get_ident()

    def require(self) -> None:
        """Raise EngineError if the caller runs in another thread."""
        if threading.get_ident() != self._thread:
            raise EngineError(
                'the engine was asked from another thread than the one it started in'
            )


def make_buffer(pipe: Pipe, lens: PinholeCamera, name: str, aux_count: int = 0) -> Any:
    """Return a buffer of a camera's image size: depth, colour and `aux_count` more planes.

    Raises
    ------
    EngineError
        If the pipe refuses it.
    """
    properties = core.FrameBufferProperties()
    properties.setRgbaBits(8, 8, 8, 8)
    properties.setDepthBits(24)
    properties.setAuxRgba(aux_count)
    size = core.WindowProperties.size(lens.image_width_px, lens.image_height_px)
    buffer = pipe.engine.makeOutput(
        pipe.host.getPipe(), name, 0, properties, size, core.GraphicsPipe.BFRefuseWindow,
        pipe.host.getGsg(), pipe.host,
    )  # fmt: skip
    if buffer is None:
        raise EngineError(
            f'no picture of {lens.image_width_px} x {lens.image_height_px} px: '
            f'{pipe.renderer} refuses it'
        )
    return buffer


def pixels_of(texture: Any, lens: PinholeCamera) -> NDArray[np.uint8]:
    """Return the pixels of a texture: blue, green, red, alpha; the lowest row first.

    Raises
    ------
    EngineError
        If nothing was drawn.
    """
    data = texture.getRamImage()
    if not data:
        raise EngineError('the engine returned no picture')
    raw = np.frombuffer(memoryview(data).cast('B'), np.uint8)
    return raw.reshape(lens.image_height_px, lens.image_width_px, -1)

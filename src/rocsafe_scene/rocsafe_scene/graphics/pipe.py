# SPDX-License-Identifier: Apache-2.0
"""Choice of a renderer: EGL, on a GPU or with Mesa's llvmpipe; else Panda3D's software pipe."""

import logging
import os
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from panda3d import core

from rocsafe_scene.errors import EngineError

_SETTINGS = """
window-type offscreen
audio-library-name null
textures-power-2 none
gl-version 3 3
notify-level-egldisplay fatal
notify-level-display fatal
notify-level-x11display fatal
notify-level-glgsg warning
texture-minfilter linear_mipmap_linear
garbage-collect-states 0
"""
EGL_PACKAGES = 'libegl1 libgl1 libgl1-mesa-dri'
# Environment variables: the value `software` chooses Panda3D's software pipe even where EGL
# exists; a number chooses one of several graphics devices, in EGL's order.
CHOICE, DEVICE = 'ROCSAFE_RENDERER', 'ROCSAFE_EGL_DEVICE'
SOFTWARE = 'software'
_SOFTWARE_SETTINGS = 'textures-power-2 down\nmax-texture-dimension 4096\n'


@dataclass(frozen=True, slots=True, eq=False)
class Pipe:
    """An opened graphics pipe.

    Attributes
    ----------
    engine, host
        Panda3D's engine, and a small buffer whose graphics context all others share.
    renderer
        Name of the renderer, as it reports it.
    is_degraded
        Whether it has no shaders: then there are no shadows, water, haze and grass.
    """

    engine: Any
    host: Any
    renderer: str
    is_degraded: bool = False


@lru_cache(maxsize=1)
def open_pipe() -> Pipe:
    """Return the EGL pipe of this machine, or Panda3D's software pipe; one for the process.

    The thread of the first call must do all drawing.

    Raises
    ------
    EngineError
        If there is neither; the text says what to install.
    """
    core.loadPrcFileData('rocsafe', _SETTINGS)
    engine = core.GraphicsEngine.getGlobalPtr()
    host = None if os.environ.get(CHOICE) == SOFTWARE else _egl_host(engine)
    if host is None:
        return _software_pipe(engine)
    name = host.getGsg().getDriverRenderer()
    return Pipe(engine, host, f'{name} {host.getGsg().getDriverVersion()}')


def _egl_host(engine: Any) -> Any:
    device = os.environ.get(DEVICE, '')
    if device.isdigit():
        # Without a choice EGL takes its default display: a GPU that has a driver.
        core.loadPrcFileData('rocsafe device', f'egl-device-index {device}')
    elif device:
        raise EngineError(f'{DEVICE} is {device!r}: must be the number of a device, from 0')
    pipe = core.GraphicsPipeSelection.getGlobalPtr().makeModulePipe('p3headlessgl')
    return _host(engine, pipe) if pipe is not None and pipe.isValid() else None


def _software_pipe(engine: Any) -> Pipe:
    core.loadPrcFileData('rocsafe software', _SOFTWARE_SETTINGS)
    selection = core.GraphicsPipeSelection.getGlobalPtr()
    pipe = selection.makePipe('TinyOffscreenGraphicsPipe', 'p3tinydisplay')
    host = _host(engine, pipe) if pipe is not None and pipe.isValid() else None
    if host is None:
        raise EngineError(
            'camera backend engine: no EGL on this machine, and no libX11 for the software pipe; '
            f'on Debian or Ubuntu: sudo apt install --no-install-recommends {EGL_PACKAGES}'
        )
    logging.getLogger(__name__).warning(
        'camera backend engine: drawn by the software pipe of Panda3D, without shadows, grass, '
        'water and haze; for all of them: sudo apt install --no-install-recommends %s',
        EGL_PACKAGES,
    )  # fmt: skip
    return Pipe(engine, host, 'Panda3D software pipe (no shadows, grass, water, haze)', True)


def _host(engine: Any, pipe: Any) -> Any:
    properties = core.FrameBufferProperties()
    properties.setRgbaBits(8, 8, 8, 8)
    properties.setDepthBits(24)
    host = engine.makeOutput(
        pipe, 'host', -100, properties, core.WindowProperties.size(16, 16),
        core.GraphicsPipe.BFRefuseWindow,
    )  # fmt: skip
    if host is not None:
        engine.openWindows()
        host.setActive(False)
    return host

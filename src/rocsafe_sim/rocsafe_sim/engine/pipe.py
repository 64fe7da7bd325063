# SPDX-License-Identifier: Apache-2.0
"""Finding something to draw with: EGL, on a GPU or on Mesa's software rasterizer."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from panda3d import core

from rocsafe_sim.errors import EngineError

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


@dataclass(frozen=True, slots=True, eq=False)
class Pipe:
    """A way to draw.

    Attributes
    ----------
    engine, host : Panda3D's engine, and the small buffer whose context all others share.
    renderer : what draws, in its own words.
    """

    engine: Any
    host: Any
    renderer: str


@lru_cache(maxsize=1)
def open_pipe() -> Pipe:
    """Return the EGL pipe of this machine; the same for all of the process.

    The thread that first asks must do all drawing.

    Raises
    ------
    EngineError: if there is none, with what to install.
    """
    core.loadPrcFileData('rocsafe', _SETTINGS)
    engine = core.GraphicsEngine.getGlobalPtr()
    pipe = core.GraphicsPipeSelection.getGlobalPtr().makeModulePipe('p3headlessgl')
    host = _host(engine, pipe) if pipe is not None and pipe.isValid() else None
    if host is None:
        raise EngineError(
            'camera backend engine: no EGL on this machine; on Debian or Ubuntu: '
            f'sudo apt install --no-install-recommends {EGL_PACKAGES}'
        )
    name = host.getGsg().getDriverRenderer()
    return Pipe(engine, host, f'{name} {host.getGsg().getDriverVersion()}')


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

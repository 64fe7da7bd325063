# SPDX-License-Identifier: Apache-2.0
"""Finding something to draw with: EGL on a GPU or Mesa, else Panda3D's software pipe."""

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
EGL, SOFTWARE = 'egl', 'software'
EGL_PACKAGES = 'libegl1 libgl1 libgl1-mesa-dri'


@dataclass(frozen=True, slots=True, eq=False)
class Pipe:
    """A way to draw.

    Attributes
    ----------
    kind : ``'egl'`` or ``'software'``.
    engine, host : Panda3D's engine, and the small buffer whose context all others share.
    renderer : what draws, in its own words.
    notice : what is missing, in one line; empty if nothing is.
    """

    kind: str
    engine: Any
    host: Any
    renderer: str
    notice: str = ''


@lru_cache(maxsize=1)
def open_pipe(wanted: str = '') -> Pipe:
    """Return the best pipe of this machine; the same for all of the process.

    The thread that first asks must do all drawing.

    Raises
    ------
    EngineError: if there is none.
    """
    core.loadPrcFileData('rocsafe', _SETTINGS)
    engine = core.GraphicsEngine.getGlobalPtr()
    selection = core.GraphicsPipeSelection.getGlobalPtr()
    if wanted != SOFTWARE:
        pipe = selection.makeModulePipe('p3headlessgl')
        host = _host(engine, pipe) if pipe is not None and pipe.isValid() else None
        if host is not None:
            name = host.getGsg().getDriverRenderer()
            return Pipe(EGL, engine, host, f'{name} {host.getGsg().getDriverVersion()}')
    pipe = selection.makePipe('TinyOffscreenGraphicsPipe', 'p3tinydisplay')
    host = _host(engine, pipe) if pipe is not None and pipe.isValid() else None
    if host is None:
        raise EngineError(
            'camera backend engine: neither EGL nor the software pipe starts; on Debian or '
            f'Ubuntu: sudo apt install {EGL_PACKAGES}'
        )
    notice = (
        'no EGL here: drawing with the software pipe, without shadows and sky light; for the '
        f'full picture on Debian or Ubuntu: sudo apt install {EGL_PACKAGES}'
    )
    return Pipe(SOFTWARE, engine, host, 'Panda3D TinyPanda', notice)


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

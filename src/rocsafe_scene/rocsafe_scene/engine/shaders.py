# SPDX-License-Identifier: Apache-2.0
"""Shader programs, each compiled only in the variants that a scene needs.

A software renderer (llvmpipe) pays for every branch of a shader, taken or not.
"""

from functools import lru_cache
from pathlib import Path
from typing import Any

from panda3d import core

_FOLDER = Path(__file__).parent
_SHARED = ('labels', 'light')
# Tag of a node with its program and switches.
_TAG = 'program'
# Vertex shaders whose name differs from that of the fragment shader.
_VERTEX = {'object': 'surface', 'sky': 'ground', 'sunlit': 'ground', 'alone': 'plain'}


@lru_cache(maxsize=64)
def shader(name: str, *switches: str) -> Any:
    """Return the program with fragment shader ``<name>.frag.glsl``, with `switches` defined."""
    vertex = _source(_VERTEX.get(name, name), 'vert', switches, ('light',))
    return core.Shader.make(core.Shader.SLGLSL, vertex, _source(name, 'frag', switches, _SHARED))


def _source(name: str, part: str, switches: tuple[str, ...], shared: tuple[str, ...]) -> str:
    text = (_FOLDER / f'{name}.{part}.glsl').read_text()
    if '#version' in text:
        return text
    defined = [f'#define {switch}' for switch in switches]
    parts = [(_FOLDER / f'{other}.glsl').read_text() for other in shared]
    return '\n'.join(['#version 330', *defined, *parts, text])


class NodeShaders:
    """Assigns shaders to nodes, in a dry or a wet variant."""

    def __init__(self) -> None:
        self._assigned: list[tuple[Any, str, tuple[str, ...]]] = []
        self._is_wet = False

    def assign(self, node: Any, name: str, *switches: str) -> None:
        """Draw `node` by the program called `name`, with `switches` defined."""
        self._assigned.append((node, name, switches))
        node.setTag(_TAG, ' '.join((name, *switches)))
        node.setShader(self._program(name, switches))

    def set_wet(self, *, is_wet: bool) -> None:
        """Give all nodes the wet or the dry variant of their shaders."""
        if is_wet == self._is_wet:
            return
        self._is_wet = is_wet
        for node, name, switches in self._assigned:
            node.setShader(self._program(name, switches))

    def leave_out_light(self, camera: Any) -> None:
        """Let a camera see depth, labels and normals of all nodes, and no picture."""
        camera.setTagStateKey(_TAG)
        for program in {(name, switches) for _, name, switches in self._assigned}:
            state = core.NodePath('state')
            state.setShader(shader(program[0], *program[1], 'LABELS'))
            camera.setTagState(' '.join((program[0], *program[1])), state.getState())

    def _program(self, name: str, switches: tuple[str, ...]) -> Any:
        if self._is_wet and name != 'foliage':
            switches = tuple(sorted({*switches, 'WET', 'GLOSSY'}))
        return shader(name, *switches)

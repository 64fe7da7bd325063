# SPDX-License-Identifier: Apache-2.0
"""The scene graph: terrain, things, grass and sky, with their shaders and textures."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np
from panda3d import core

from rocsafe_sim.engine import upload
from rocsafe_sim.scene.classes import class_number
from rocsafe_sim.scene.environment import GROUND_NUMBER, Environment, Piece, SceneObject
from rocsafe_sim.scene.grain import grain_tile
from rocsafe_sim.scene.ground_picture import GroundMap
from rocsafe_sim.scene.light import Lighting
from rocsafe_sim.scene.mesh import Floats
from rocsafe_sim.scene.parts.plants import LEAFY, coarser
from rocsafe_sim.scene.shapes import ball
from rocsafe_sim.scene.surfaces import LOOKS, Surface

# Bits of the cameras that see a node; ALONE sees the ground and what it is shown.
EYE, SUN, BARE, ALONE = (core.BitMask32.bit(number) for number in range(4))
_FOLDER = Path(__file__).parent
_INNER_CELLS, _OUTER_CELLS = 16, 12
# Up to these distances, metres, leaves and grass are drawn in full, thinned, thinner.
_LEAVES_M = (58.0, 120.0, 9000.0)
_GRASS_M = (75.0,)
# Drawing order: things from near to far, then the ground that they hide, the sky last.
_THINGS, _GROUND, _SKY = 20, 30, 40
_CLOUDS = {'clear': 0.8, 'overcast': 0.25, 'wet': 0.2, 'fog': 0.0, 'dusk': 0.9}


def shader(name: str, *switches: str, vertex: str = 'surface') -> Any:
    """Return the program whose fragment part is ``<name>.frag.glsl``, with `switches` defined."""
    fragment = (_FOLDER / f'{name}.frag.glsl').read_text()
    if '#version' not in fragment:
        shared = [(_FOLDER / f'{part}.glsl').read_text() for part in ('labels', 'light')]
        defined = [f'#define {switch}' for switch in switches]
        fragment = '\n'.join(['#version 330', *defined, *shared, fragment])
    source = (_FOLDER / f'{vertex}.vert.glsl').read_text()
    return core.Shader.make(core.Shader.SLGLSL, source, fragment)


class Stage:
    """All that is drawn, under one root.

    Parameters
    ----------
    environment : what there is.
    weather : for the clouds.
    """

    def __init__(self, environment: Environment, weather: str) -> None:
        core.CullBinManager.getGlobalPtr().addBin(
            'near_first', core.CullBinManager.BTFrontToBack, _THINGS
        )
        self.root = core.NodePath('scene')
        self.root.setShader(shader('object'))
        self.root.setShaderInput('grain', self._grain())
        self.root.setShaderInput('looks', _look_table())
        self._foliage = shader('foliage')
        self._moving: list[tuple[SceneObject, Any]] = []
        self._weather = weather
        self.things: dict[int, Any] = {}
        self._add_ground(environment)
        self._add_objects(environment)
        self._add_sky()

    @property
    def has_motion(self) -> bool:
        """Whether anything moves."""
        return bool(self._moving)

    def light(self, lighting: Lighting, weather: str | None = None) -> None:
        """Set the light, and the weather if another one is given."""
        self._weather = weather or self._weather
        for name in ('sun_direction', 'zenith', 'horizon', 'bounce'):
            self.root.setShaderInput(name, core.LVecBase3f(*getattr(lighting, name)))
        self.root.setShaderInput('sun_light', core.LVecBase3f(*lighting.sun))
        clouds = _CLOUDS.get(self._weather, 0.5)
        self.root.setShaderInput(
            'air',
            core.LVecBase4f(lighting.haze_per_m, lighting.wetness, lighting.exposure, clouds),
        )

    def move(self, time_s: float) -> None:
        """Put what moves where it is at a time."""
        for thing, node in self._moving:
            assert thing.path is not None  # noqa: S101 - only such are kept
            place, yaw = thing.path.shift_at(time_s)
            node.setPosHpr(*place.tolist(), float(np.degrees(yaw)), 0.0, 0.0)

    def arrange(self, objects: Sequence[SceneObject]) -> None:
        """Put things where `objects`, the stage's own moved, have them; hide the rest."""
        left = dict(self.things)
        for thing in objects:
            parent = left.pop(thing.number)
            parent.show()
            for placed, piece in zip(parent.getChildren(), thing.pieces, strict=True):
                _place(placed, piece, is_moving=thing.path is not None)
        for parent in left.values():
            parent.hide()

    def _grain(self) -> Any:
        return upload.colour_texture('grain', grain_tile()[..., [2, 1, 0, 3]], is_tile=True)

    def _add_ground(self, environment: Environment) -> None:
        ground = self.root.attachNewNode('ground')
        moving = ('MOTION',) if any(thing.path for thing in environment.objects) else ()
        ground.hide(SUN)
        ground.setBin('fixed', _GROUND)
        meta = (0, GROUND_NUMBER, class_number('water'), class_number('asphalt'))
        ground.setShaderInput('meta', core.LVecBase4i(*meta))
        terrain = environment.terrain
        inner, around = ground.attachNewNode('inner'), ground.attachNewNode('around')
        inner.setShader(shader('ground', 'INNER', *moving))
        around.setShader(shader('ground'))
        around.hide(BARE)
        _dress(inner, environment.inner)
        _dress(around, environment.outer)
        self.inner = inner
        for mesh in upload.grid_meshes(terrain.inner, _INNER_CELLS):
            inner.attachNewNode(upload.geom_node('chunk', mesh))
        for mesh in upload.grid_meshes(terrain.outer, _OUTER_CELLS, terrain.inner):
            around.attachNewNode(upload.geom_node('chunk', mesh))
        for mesh in upload.grid_meshes(terrain.far, 200, terrain.outer):
            around.attachNewNode(upload.geom_node('far', mesh))
        grass = self.root.attachNewNode('grass')
        grass.hide(SUN | BARE | ALONE)
        grass.setTwoSided(True)
        grass.setShader(self._foliage)
        grass.setShaderInput('meta', core.LVecBase4i(class_number('grass'), GROUND_NUMBER, 0, 0))
        grass.setShaderInput('shift', core.LVecBase4f(0.0))
        grass.setBin('near_first', 0)
        for mesh in environment.tufts:
            _add_steps(
                grass, [upload.geom_node('tufts', mesh)], mesh.bounds.mean(axis=0), _GRASS_M
            )

    def _add_objects(self, environment: Environment) -> None:
        nodes: dict[int, list[Any]] = {}
        things = self.root.attachNewNode('things')
        things.setBin('near_first', 0)
        things.hide(BARE)
        for thing in environment.objects:
            parent = things.attachNewNode(thing.name)
            parent.hide(ALONE)
            self.things[thing.number] = parent
            kind = class_number(thing.label)
            parent.setShaderInput('meta', core.LVecBase4i(kind, thing.number, 0, 0))
            hashed = crc32(thing.name.encode())
            parent.setShaderInput(
                'shift', core.LVecBase4f((hashed & 255) / 256.0, (hashed >> 8 & 255) / 256.0, 0, 0)
            )
            if thing.is_foliage:
                parent.setTwoSided(True)
                parent.setShader(self._foliage)
            for piece in thing.pieces:
                _add_piece(parent, thing, piece, nodes)
            if thing.path is not None:
                self._moving.append((thing, parent))

    def _add_sky(self) -> None:
        dome = ball(6000.0, 24).flipped()
        self.sky = self.root.attachNewNode(upload.geom_node('sky', dome))
        self.sky.setShader(shader('sky'))
        self.sky.setBin('fixed', _SKY)
        self.sky.setDepthWrite(False)
        self.sky.hide(SUN | BARE | ALONE)


def _add_piece(parent: Any, thing: SceneObject, piece: Piece, nodes: dict[int, list[Any]]) -> None:
    # Things that are alike share their mesh, also in the engine's memory.
    key = id(piece.mesh)
    if key not in nodes:
        meshes = coarser(piece.mesh) if thing.label in LEAFY else [piece.mesh]
        nodes[key] = [upload.geom_node(thing.name, mesh) for mesh in meshes]
    placed = parent.attachNewNode('piece')
    _place(placed, piece, is_moving=thing.path is not None)
    _add_steps(placed, nodes[key], piece.mesh.bounds.mean(axis=0), _LEAVES_M)


def _place(placed: Any, piece: Piece, *, is_moving: bool) -> None:
    rows = piece.rotation.T
    offset = np.zeros(3) if is_moving else piece.offset
    values = [*rows[0], 0.0, *rows[1], 0.0, *rows[2], 0.0, *offset, 1.0]
    placed.setMat(core.LMatrix4f(*(float(value) for value in values)))


def _add_steps(parent: Any, nodes: list[Any], middle: Floats, ranges: tuple[float, ...]) -> None:
    """Add one of `nodes` under `parent`, the finer the nearer the camera is to `middle`.

    The k-th is drawn up to the k-th of `ranges`, metres; a single one without ranges always.
    """
    if len(nodes) == 1 and len(ranges) > 1:
        parent.attachNewNode(nodes[0])
        return
    steps = core.LODNode('steps')
    steps.setCenter(core.LPoint3f(*(float(value) for value in middle)))
    placed = parent.attachNewNode(steps)
    for node, near, far in zip(nodes, (0.0, *ranges), ranges, strict=False):
        steps.addSwitch(far, near)
        placed.attachNewNode(node)


def _dress(node: Any, ground: GroundMap) -> None:
    node.setShaderInput('ground', upload.colour_texture('ground', ground.colours))
    node.setShaderInput('classes', upload.class_texture('classes', ground.classes))
    width, height = ground.size_m
    area = core.LVecBase4f(ground.west_m, ground.south_m, 1.0 / width, 1.0 / height)
    node.setShaderInput('ground_area', area)


def _look_table() -> Any:
    table = core.PTA_LVecBase4f()
    for number in range(16):
        look = LOOKS[Surface(number)] if number < len(Surface) else LOOKS[Surface.MATTE]
        table.pushBack(core.LVecBase4f(look.gloss, look.sharpness, look.grain, look.through))
    return table

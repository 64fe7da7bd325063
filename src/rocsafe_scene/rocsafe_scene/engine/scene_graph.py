# SPDX-License-Identifier: Apache-2.0
"""The scene graph: terrain, objects, grass and sky, with their shaders and textures."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any
from zlib import crc32

import numpy as np
from panda3d import core

from rocsafe_scene.engine.drawing_options import DETAIL
from rocsafe_scene.engine.shaders import NodeShaders
from rocsafe_scene.graphics import upload
from rocsafe_scene.graphics.memory import drop_mapped_pages
from rocsafe_scene.graphics.pipe import Pipe
from rocsafe_scene.ground.ground_map import GroundMap
from rocsafe_scene.mesh.classes import class_number
from rocsafe_scene.mesh.coarse import clustered
from rocsafe_scene.mesh.grain import LEAVES, grain_tile, leaf_tile
from rocsafe_scene.mesh.mesh import Floats, Mesh
from rocsafe_scene.mesh.shapes import ball
from rocsafe_scene.mesh.surfaces import LOOKS, Surface
from rocsafe_scene.parts.thinning import LEAFY, coarser, sparser
from rocsafe_scene.scene.environment import GROUND_NUMBER, Environment, Piece, SceneObject
from rocsafe_scene.scene.sunlight import Lighting

# Camera mask bits. ALL cameras see everything, SUN sees standing objects, BARE the bare ground,
# ALONE the ground and chosen objects, MOVING sees moving objects.
ALL, SUN, BARE, ALONE, MOVING = (core.BitMask32.bit(number) for number in range(5))
_INNER_CELLS, _OUTER_CELLS, _FAR_CELLS = 16, 12, 20
# Surfaces that are drawn with gloss.
_GLOSSY = {int(surface) for surface, look in LOOKS.items() if look.gloss > 0.09}
# Drawing order: objects from near to far, leaves (which have another shader), the ground that both
# hide, the sky.
_THINGS, _LEAVES, _GROUND, _SKY = 20, 25, 30, 40


class SceneGraph:
    """Everything that is drawn, under one root node.

    Parameters
    ----------
    environment
        Scene to draw.
    pipe
        Pipe that will draw it.
    """

    def __init__(self, environment: Environment, pipe: Pipe) -> None:
        bins = core.CullBinManager.getGlobalPtr()
        for name, order in (('near_first', _THINGS), ('leaves', _LEAVES)):
            bins.addBin(name, core.CullBinManager.BTFrontToBack, order)
        self.root = core.NodePath('scene')
        self.root.setShaderInput('grain', self._grain())
        self.root.setShaderInput('leaves', upload.grey_texture('leaves', leaf_tile()))
        self.root.setShaderInput('leaf_scale', 1.0 / LEAVES.width_m)
        self.root.setShaderInput('looks', _look_table())
        self._pipe = pipe
        self._shaders = NodeShaders()
        self._moving: list[tuple[SceneObject, Any]] = []
        self.things: dict[int, Any] = {}
        self._add_ground(environment)
        self._add_objects(environment)
        self._add_sky()

    @property
    def has_motion(self) -> bool:
        """Whether anything moves."""
        return bool(self._moving)

    def light(self, lighting: Lighting) -> None:
        """Set the light."""
        self._shaders.set_wet(is_wet=lighting.wetness > 0.0)
        for name in ('sun_direction', 'zenith', 'horizon', 'bounce'):
            self.root.setShaderInput(name, core.LVecBase3f(*getattr(lighting, name)))
        self.root.setShaderInput('sun_light', core.LVecBase3f(*lighting.sun))
        air = (lighting.haze_per_m, lighting.wetness, lighting.exposure, lighting.clouds)
        self.root.setShaderInput('air', core.LVecBase4f(*air))

    def leave_out_light(self, camera: Any) -> None:
        """Let a camera see all but the picture."""
        self._shaders.leave_out_light(camera)

    def move(self, time_s: float) -> None:
        """Move objects to their places at a time, seconds after the start."""
        for thing, node in self._moving:
            assert thing.path is not None  # noqa: S101 - only such are kept
            place, yaw = thing.path.shift_at(time_s)
            node.setPosHpr(*place.tolist(), float(np.degrees(yaw)), 0.0, 0.0)

    def arrange(self, objects: Sequence[SceneObject]) -> None:
        """Place the objects as `objects` says, and hide those that are missing in it."""
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
        ground.hide(SUN | MOVING)
        ground.setBin('fixed', _GROUND)
        meta = (0, GROUND_NUMBER, class_number('water'), class_number('asphalt'))
        ground.setShaderInput('meta', core.LVecBase4i(*meta))
        terrain = environment.terrain
        inner, around = ground.attachNewNode('inner'), ground.attachNewNode('around')
        self._shaders.assign(around, 'ground', 'FAR', 'GLOSSY', 'WATER')
        around.hide(BARE)
        self._lay(inner, environment.inner)
        self._lay(around, environment.outer)
        self.inner = inner
        self.inner_area = (environment.inner.west_m, environment.inner.south_m,
                           *environment.inner.size_m)  # fmt: skip
        for mesh in upload.grid_meshes(terrain.inner, _INNER_CELLS):
            chunk = inner.attachNewNode('chunk')
            water = ('GLOSSY', 'WATER') if _has_water(mesh, environment.inner) else ()
            nodes = [upload.geom_node('chunk', mesh)] * 2
            steps = _add_steps(chunk, nodes, mesh.bounds.mean(axis=0), DETAIL.grain_m)
            self._assign_steps(steps, 'ground', 'INNER', *moving, *water)
        for mesh in upload.grid_meshes(terrain.outer, _OUTER_CELLS, terrain.inner):
            around.attachNewNode(upload.geom_node('chunk', mesh))
        for mesh in upload.grid_meshes(terrain.far, _FAR_CELLS, terrain.outer):
            around.attachNewNode(upload.geom_node('far', mesh))
        self._add_grass(environment.tufts)

    def _lay(self, node: Any, ground: GroundMap) -> None:
        picture = upload.colour_texture('ground', ground.colours)
        # Uploaded at once: three copies at a time would take most of the memory of a scene.
        host = self._pipe.host
        picture.prepare(host.getGsg().getPreparedObjects())
        host.setActive(True)
        self._pipe.engine.renderFrame()
        host.setActive(False)
        drop_mapped_pages(ground.colours)
        node.setShaderInput('ground', picture)
        node.setShaderInput('classes', upload.class_texture('classes', ground.classes))
        width, height = ground.size_m
        area = core.LVecBase4f(ground.west_m, ground.south_m, 1.0 / width, 1.0 / height)
        node.setShaderInput('ground_area', area)

    def _add_grass(self, tufts: Sequence[Mesh]) -> None:
        grass = self.root.attachNewNode('grass')
        grass.hide(SUN | BARE | ALONE | MOVING)
        grass.setTwoSided(True)
        self._shaders.assign(grass, 'foliage')
        grass.setShaderInput('meta', core.LVecBase4i(class_number('grass'), GROUND_NUMBER, 0, 0))
        grass.setBin('leaves', 0)
        for mesh in tufts:
            nodes = [upload.geom_node('tufts', step) for step in (mesh, sparser(mesh))]
            _add_steps(grass, nodes, mesh.bounds.mean(axis=0), DETAIL.grass_m)

    def _add_objects(self, environment: Environment) -> None:
        shapes: dict[int, _Shape] = {}
        things = self.root.attachNewNode('things')
        things.setBin('near_first', 0)
        things.hide(BARE)
        has_motion = any(thing.path for thing in environment.objects)
        for thing in environment.objects:
            parent = things.attachNewNode(thing.name)
            parent.hide(ALONE | (MOVING if thing.path is None else SUN))
            self.things[thing.number] = parent
            kind = class_number(thing.label)
            parent.setShaderInput('meta', core.LVecBase4i(kind, thing.number, 0, 0))
            hashed = crc32(thing.name.encode())
            parent.setShaderInput(
                'shift', core.LVecBase4f((hashed & 255) / 256.0, (hashed >> 8 & 255) / 256.0, 0, 0)
            )
            if thing.is_foliage:
                parent.setTwoSided(True)
                parent.setBin('leaves', 0)
            for piece in thing.pieces:
                key = id(piece.mesh)
                if key not in shapes:
                    shapes[key] = _shape(thing, piece.mesh)
                steps = _add_piece(parent, thing, piece, shapes[key])
                name = 'foliage' if thing.is_foliage else 'object'
                switches = _switches(thing, piece, shapes[key])
                if has_motion and name == 'object' and 'FAR' not in switches:
                    switches = (*switches, 'MOTION')
                self._assign_steps(steps, name, *switches)
            if thing.path is not None:
                self._moving.append((thing, parent))

    def _assign_steps(self, steps: list[Any], name: str, *switches: str) -> None:
        """Assign a shader to nodes; all but the first get the variant for distant objects."""
        for number, node in enumerate(steps):
            distant = ('DISTANT',) if number and name != 'foliage' else ()
            self._shaders.assign(node, name, *switches, *distant)

    def _add_sky(self) -> None:
        dome = ball(6000.0, 24).flipped()
        self.sky = self.root.attachNewNode(upload.geom_node('sky', dome))
        self._shaders.assign(self.sky, 'sky')
        self.sky.setBin('fixed', _SKY)
        self.sky.setDepthWrite(False)
        self.sky.hide(SUN | BARE | ALONE | MOVING)


@dataclass(frozen=True, slots=True, eq=False)
class _Shape:
    """A mesh and simpler versions of it as nodes; objects of the same shape share them."""

    nodes: list[Any]
    bounds: Floats
    is_glossy: bool
    has_skin: bool


def _shape(thing: SceneObject, mesh: Mesh) -> _Shape:
    nodes = [upload.geom_node(thing.name, step) for step in _steps(thing, mesh)]
    kinds = np.flatnonzero(np.bincount(mesh.colours[:, 3]))
    is_glossy = not thing.is_foliage and bool(_GLOSSY & {*kinds.tolist()})
    return _Shape(nodes, mesh.bounds, is_glossy, Surface.CROWN in kinds)


def _steps(thing: SceneObject, mesh: Mesh) -> list[Mesh]:
    """Return a mesh and simpler versions of it for larger distances."""
    if thing.label in LEAFY:
        return coarser(mesh)
    if len(mesh.triangles) < DETAIL.least_triangles:
        return [mesh]
    return [mesh, *(clustered(mesh, cell_m) for cell_m in DETAIL.cells_m)]


def _add_piece(parent: Any, thing: SceneObject, piece: Piece, shape: _Shape) -> list[Any]:
    placed = parent.attachNewNode('piece')
    _place(placed, piece, is_moving=thing.path is not None)
    ranges = DETAIL.leaves_m if thing.label in LEAFY else DETAIL.objects_m
    return _add_steps(placed, shape.nodes, shape.bounds.mean(axis=0), ranges)


def _switches(thing: SceneObject, piece: Piece, shape: _Shape) -> tuple[str, ...]:
    """Return the shader switches that a piece needs."""
    skin = ('SKIN',) if shape.has_skin else ()
    if thing.path is None:
        corners = np.array(np.meshgrid(*shape.bounds.T)).reshape(3, -1).T
        places = corners @ piece.rotation.T + piece.offset
    else:
        places = thing.path.places
    is_far = np.linalg.norm(places[:, :2], axis=1).max() > DETAIL.near_shadow_m
    return (*(('FAR',) if is_far else ()), *(('GLOSSY',) if shape.is_glossy else ()), *skin)


def _has_water(chunk: Mesh, ground: GroundMap) -> bool:
    """Return whether there is water on a chunk of ground."""
    low, high = chunk.bounds[:, :2]
    sides = [np.arange(a, b, 2.0 * ground.texel_m) for a, b in zip(low, high, strict=True)]
    places = np.stack(np.meshgrid(*sides), axis=-1).reshape(-1, 2)
    return bool(np.any(ground.classes_at(places) == class_number('water')))


def _place(placed: Any, piece: Piece, *, is_moving: bool) -> None:
    rows = piece.rotation.T
    offset = np.zeros(3) if is_moving else piece.offset
    values = [*rows[0], 0.0, *rows[1], 0.0, *rows[2], 0.0, *offset, 1.0]
    placed.setMat(core.LMatrix4f(*(float(value) for value in values)))


def _add_steps(
    parent: Any, nodes: list[Any], middle: Floats, ranges: tuple[float, ...]
) -> list[Any]:
    """Attach `nodes` to `parent` as levels of detail; the distance is measured to `middle`.

    Node k is drawn up to `ranges[k]` metres; a single node is drawn at any distance.
    """
    if len(nodes) == 1 and len(ranges) > 1:
        return [parent.attachNewNode(nodes[0])]
    steps = core.LODNode('steps')
    steps.setCenter(core.LPoint3f(*(float(value) for value in middle)))
    placed = parent.attachNewNode(steps)
    found = []
    for node, near, far in zip(nodes, (0.0, *ranges), ranges, strict=False):
        steps.addSwitch(far, near)
        step = placed.attachNewNode('step')
        step.attachNewNode(node)
        found.append(step)
    return found


def _look_table() -> Any:
    table = core.PTA_LVecBase4f()
    for number in range(16):
        look = LOOKS[Surface(number)] if number < len(Surface) else LOOKS[Surface.MATTE]
        table.pushBack(core.LVecBase4f(look.gloss, look.sharpness, look.grain, look.through))
    return table

# SPDX-License-Identifier: Apache-2.0
"""Draws a scene without EGL: simple light, exact labels and depth.

There are two passes: the image, and the number of the triangle at each pixel. Depth is computed
where the ray of a pixel meets the plane of that triangle, so it is exact where the label is.
"""

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from panda3d import core

from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_scene.engine.software_scene_graph import KNOW, LOOK, SoftwareSceneGraph
from rocsafe_scene.graphics.buffers import OneThread, make_buffer, pixels_of
from rocsafe_scene.graphics.lens import NEAR_M, node_matrix, pinhole_lens
from rocsafe_scene.graphics.pipe import Pipe, open_pipe
from rocsafe_scene.graphics.rendering import Purpose, Rendering
from rocsafe_scene.ground.ground_map import GroundMap
from rocsafe_scene.mesh.mesh import Floats, unit
from rocsafe_scene.scene.environment import Environment
from rocsafe_scene.scene.sunlight import Lighting

# Depth may exceed that of the corners of a triangle by this share.
_SLACK = np.float32(0.04)
# Priority of the state that draws numbers over the states of the nodes.
_OVER = 1000


class SoftwareRenderer:
    """Draws one scene on the software pipe. All calls must come from the thread that made it.

    Parameters
    ----------
    environment
        Scene to draw.
    lighting
        Light of the scene.
    """

    def __init__(self, environment: Environment, lighting: Lighting) -> None:
        self.thread = OneThread()
        self.pipe: Pipe = open_pipe()
        self.graph = SoftwareSceneGraph(environment, lighting)
        self.graph.move(0.0)
        self.sky = np.clip(np.sqrt(0.6 * np.array(lighting.horizon)), 0.0, 1.0)

    def set_time(self, time_s: float) -> None:
        """Move objects to their places `time_s` seconds after the start."""
        self.thread.require()
        self.graph.move(time_s)

    def camera(
        self, lens: PinholeCamera, _purpose: Purpose = Purpose.ALL
    ) -> 'SoftwareRendererCamera':
        """Return a camera of this scene, which draws all for any purpose."""
        self.thread.require()
        return SoftwareRendererCamera(self, lens)


class SoftwareRendererCamera:
    """A camera with its buffers; make it once and use it again."""

    def __init__(self, renderer: SoftwareRenderer, lens: PinholeCamera) -> None:
        self._cameras: list[Any] = []
        self.look_through(lens)
        self._renderer = renderer
        self._node = renderer.graph.root.attachNewNode('eye')
        self._passes = [
            self._pass('picture', LOOK, None),
            self._pass('triangles', KNOW, _numbering()),
        ]

    def _pass(self, name: str, mask: Any, state: Any) -> tuple[Any, Any]:
        buffer = make_buffer(self._renderer.pipe, self.lens, name)
        texture = core.Texture(name)
        buffer.addRenderTexture(texture, core.GraphicsOutput.RTMCopyRam)
        sky = (*self._renderer.sky.tolist(), 1.0) if state is None else (0.0, 0.0, 0.0, 0.0)
        buffer.setClearColor(core.LVecBase4f(*sky))
        camera = core.Camera(name, pinhole_lens(self.lens))
        self._cameras.append(camera)
        camera.setScene(self._renderer.graph.root)
        camera.setCameraMask(mask)
        if state is not None:
            camera.setInitialState(state)
        buffer.makeDisplayRegion().setCamera(self._node.attachNewNode(camera))
        buffer.setActive(False)
        return buffer, texture

    def look_through(self, lens: PinholeCamera) -> None:
        """Use another lens, of the same image size."""
        self.lens = lens
        for camera in self._cameras:
            camera.setLens(pinhole_lens(lens))
        matrix = lens.matrix
        # Rays (x, y, 1) through the pixels: x of each column, y of each row.
        self._x = ((np.arange(lens.image_width_px) - matrix[0, 2]) / matrix[0, 0])[None]
        self._y = ((np.arange(lens.image_height_px) - matrix[1, 2]) / matrix[1, 1])[:, None]

    def resolve(self, focal_px: float) -> None:
        """Do nothing: here the level of detail does not depend on the focal length."""

    def expose(self, position_enu: Floats, rotation_enu_from_optical: Floats) -> Rendering:
        """Return what is seen from a pose.

        Parameters
        ----------
        position_enu : (3,)
            Position of the camera, metres.
        rotation_enu_from_optical : (3, 3)
            Rotation of the camera, columns right, down, ahead.
        """
        self._renderer.thread.require()
        self._node.setMat(node_matrix(position_enu, rotation_enu_from_optical))
        for buffer, _ in self._passes:
            buffer.setActive(True)
        self._renderer.pipe.engine.renderFrame()
        for buffer, _ in self._passes:
            buffer.setActive(False)
        pose = np.asarray(position_enu, float), np.asarray(rotation_enu_from_optical, float)
        return self._frame(*pose)

    def close(self) -> None:
        """Release the buffers."""
        for buffer, _ in self._passes:
            self._renderer.pipe.engine.removeWindow(buffer)
        self._node.removeNode()

    def _plane(self, number: int) -> NDArray[np.uint8]:
        return pixels_of(self._passes[number][1], self.lens)

    def _frame(self, position: Floats, rotation: Floats) -> Rendering:
        triangles = self._renderer.graph.triangles
        packed = np.asarray(cv2.flip(self._plane(1), 0)).view(np.uint32)[..., 0]
        drawn = packed & np.uint32(0xFFFFFF)
        # Numbers out of range come from edges that the pipe blended: taken as sky.
        drawn[drawn >= len(triangles.owners)] = 0
        chosen, row = _ranked(drawn, len(triangles.owners))
        placed = triangles.placed(chosen)
        owner = triangles.owners[chosen]
        normal = unit(np.cross(placed[:, 1] - placed[:, 0], placed[:, 2] - placed[:, 0]))
        depth = self._depth(placed, normal, (position, rotation), row)
        depth[drawn == 0] = np.inf
        return Rendering(
            image=np.asarray(cv2.flip(cv2.cvtColor(self._plane(0), cv2.COLOR_BGRA2BGR), 0)),
            depth_m=depth,
            numbers=_taken(triangles.numbers[owner], row),
            classes=self._classes(_taken(triangles.kinds[owner], row), depth, position, rotation),
            normals=_taken(_packed(normal), row).view(np.uint8).reshape(*row.shape, 4)[..., :3],
        )

    def _depth(
        self, placed: Floats, normal: Floats, pose: tuple[Floats, Floats], row: NDArray[Any]
    ) -> NDArray[np.float32]:
        """Return the depth, metres, at which each ray meets the plane of its triangle.

        A plane n x = b is met by the ray r at depth b / (n r); within a little more than the
        depths of the corners, as a pixel on an edge may just miss its triangle.
        """
        position, rotation = pose
        away = placed - position
        height = np.einsum('ij,ij->i', normal, away[:, 0])
        plane = normal @ rotation / np.where(np.abs(height) > 1e-9, height, 1e-9)[:, None]
        a, b, c = (_taken(part, row) for part in plane.astype(np.float32).T)
        a *= self._x.astype(np.float32)
        b *= self._y.astype(np.float32)
        a += b
        a += c
        corner = (away @ rotation[:, 2]).astype(np.float32)
        low = np.maximum((1.0 - _SLACK) * corner.min(axis=1), np.float32(NEAR_M))
        high = np.maximum((1.0 + _SLACK) * corner.max(axis=1), low)
        with np.errstate(divide='ignore'):
            np.divide(np.float32(1.0), a, out=a)
        return np.clip(a, _taken(low, row), _taken(high, row), out=a)

    def _classes(
        self,
        kinds: NDArray[np.int16],
        depth: NDArray[np.float32],
        position: Floats,
        rotation: Floats,
    ) -> NDArray[np.uint8]:
        """Return the class of each pixel; the ground's is read from its maps."""
        is_ground = kinds < 0
        reach = np.where(is_ground, depth, np.float32(0.0))
        east, north = (
            (reach * self._along(rotation[axis]) + np.float32(position[axis])) for axis in (0, 1)
        )
        inner, outer = self._renderer.graph.ground_maps
        found = _class_picture(inner, east, north)
        width, height = inner.size_m
        is_inner = (np.abs(east - (inner.west_m + 0.5 * width)) < 0.5 * width) & (
            np.abs(north - (inner.south_m + 0.5 * height)) < 0.5 * height
        )
        if not is_inner.all():
            found = np.where(is_inner, found, _class_picture(outer, east, north))
        return np.where(is_ground, found, kinds.astype(np.uint8))

    def _along(self, row: Floats) -> NDArray[np.float32]:
        """Return the product of each pixel's ray with a row of the rotation."""
        x, y = self._x.astype(np.float32), self._y.astype(np.float32)
        return x * np.float32(row[0]) + (y * np.float32(row[1]) + np.float32(row[2]))


def _class_picture(
    ground: GroundMap, east: NDArray[np.float32], north: NDArray[np.float32]
) -> NDArray[np.uint8]:
    """Return the class numbers of a map at each pixel's place, clamped to the map."""
    size_m = ground.size_m
    rows, columns = ground.classes.shape
    column = (east - np.float32(ground.west_m)) * np.float32(columns / size_m[0]) - np.float32(0.5)
    row = (north - np.float32(ground.south_m)) * np.float32(rows / size_m[1]) - np.float32(0.5)
    return np.asarray(
        cv2.remap(ground.classes, column, row, cv2.INTER_NEAREST, borderMode=cv2.BORDER_REPLICATE)
    )


def _packed(normals: Floats) -> NDArray[np.uint32]:
    """Return unit vectors (n, 3) as four bytes in one number, which are read together."""
    found = np.full((len(normals), 4), 255, np.uint8)
    found[:, :3] = np.rint(127.5 + 127.5 * normals)
    return found.view(np.uint32)[:, 0]


def _ranked(drawn: NDArray[np.uint32], count: int) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return the distinct values of `drawn`, all below `count`, and each pixel's index."""
    # The integer type that numpy indexes with, so that no conversion is needed.
    index = drawn.astype(np.intp)
    is_drawn = np.zeros(count, bool)
    is_drawn[index] = True
    chosen = np.flatnonzero(is_drawn)
    rank = np.empty(count, np.intp)
    rank[chosen] = np.arange(len(chosen))
    return chosen, _taken(rank, index)


def _taken(values: NDArray[Any], row: NDArray[Any]) -> NDArray[Any]:
    """Return the row of each pixel, without bounds checks, which would double the time."""
    return np.take(values, row, mode='clip')


def _numbering() -> Any:
    """Return the state that draws numbers: no light, no texture, one colour a triangle."""
    node = core.NodePath('numbering')
    node.setLightOff(_OVER)
    node.setTextureOff(_OVER)
    node.setAttrib(core.ShadeModelAttrib.make(core.ShadeModelAttrib.MFlat), _OVER)
    node.setAttrib(core.ColorAttrib.makeVertex(), _OVER)
    return node.getState()

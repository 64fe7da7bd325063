# SPDX-License-Identifier: Apache-2.0
"""Draws a scene from any pose: image, depth, labels and normals in one pass."""

from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from panda3d import core

from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_scene.engine.drawing_options import DETAIL
from rocsafe_scene.engine.scene_graph import ALL, SceneGraph
from rocsafe_scene.engine.shadow_maps import ShadowMaps
from rocsafe_scene.engine.smoothing import smoothed
from rocsafe_scene.graphics.buffers import OneThread, make_buffer, pixels_of
from rocsafe_scene.graphics.lens import flat_lens, node_matrix, pinhole_lens
from rocsafe_scene.graphics.memory import return_freed_memory
from rocsafe_scene.graphics.pipe import Pipe, open_pipe
from rocsafe_scene.graphics.rendering import Purpose, Rendering
from rocsafe_scene.mesh.mesh import Floats
from rocsafe_scene.scene.environment import Environment, SceneObject
from rocsafe_scene.scene.sunlight import Lighting

_PICTURE, _DEPTH, _LABELS, _NORMALS = range(4)
_PLANES = (
    core.GraphicsOutput.RTPColor,
    core.GraphicsOutput.RTPAuxRgba0,
    core.GraphicsOutput.RTPAuxRgba1,
    core.GraphicsOutput.RTPAuxRgba2,
)
# What is read back. Edges are smoothed where labels and normals have them.
_READ = {
    Purpose.ALL: (_PICTURE, _DEPTH, _LABELS, _NORMALS),
    Purpose.IMAGE: (_PICTURE, _LABELS, _NORMALS),
    Purpose.TRUTH: (_DEPTH, _LABELS, _NORMALS),
}
# The class is the highest byte of a label, the instance the others.
_CLASS_BYTE, _NUMBER_MASK = 3, 0xFFFFFF
_NO_BYTES: NDArray[np.uint8] = np.empty((0, 0), np.uint8)
_NO_DEPTH: NDArray[np.float32] = np.empty((0, 0), np.float32)


class Renderer:
    """Draws one scene. All calls must come from the thread that made it.

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
        self.graph = SceneGraph(environment, self.pipe)
        self.graph.light(lighting)
        self.graph.move(0.0)
        return_freed_memory()
        self._shadow_maps = ShadowMaps(self.pipe, self.graph, lighting)
        return_freed_memory()
        self._time_s = 0.0

    def set_time(self, time_s: float) -> None:
        """Move objects, and their shadows, to their places `time_s` seconds after the start."""
        self.thread.require()
        if time_s != self._time_s and self.graph.has_motion:
            self.graph.move(time_s)
            self._shadow_maps.follow()
        self._time_s = time_s

    def rearrange(self, objects: Sequence[SceneObject], lighting: Lighting) -> None:
        """Move or hide objects, and change the light.

        `objects` are those of the environment, possibly in other places; missing ones are hidden.
        """
        self.thread.require()
        self.graph.arrange(objects)
        self.relight(lighting)

    def relight(self, lighting: Lighting) -> None:
        """Change the light."""
        self.thread.require()
        self.graph.light(lighting)
        self._shadow_maps.relight(lighting)

    def camera(self, lens: PinholeCamera, purpose: Purpose = Purpose.ALL) -> 'RendererCamera':
        """Return a camera of this scene."""
        self.thread.require()
        return RendererCamera(self, lens, purpose)


class RendererCamera:
    """A camera with its buffer; make it once and use it again."""

    def __init__(self, renderer: Renderer, lens: PinholeCamera, purpose: Purpose) -> None:
        self.lens = lens
        self._renderer, self._read = renderer, _READ[purpose]
        engine = renderer.pipe.engine
        self._textures = [core.Texture(f'plane {number}') for number in range(len(_PLANES))]
        self._buffer = self._make_buffer(renderer.pipe)
        self._camera = core.Camera('eye', pinhole_lens(lens))
        self._camera.setScene(renderer.graph.root)
        self._camera.setCameraMask(ALL)
        if purpose is Purpose.TRUTH:
            renderer.graph.leave_out_light(self._camera)
        self.resolve(lens.focal_px)
        self._node = renderer.graph.root.attachNewNode(self._camera)
        self._buffer.makeDisplayRegion().setCamera(self._node)
        self._buffer.setActive(False)
        self._engine = engine

    def _make_buffer(self, pipe: Pipe) -> Any:
        buffer = make_buffer(pipe, self.lens, 'eye', aux_count=len(_PLANES) - 1)
        for number, plane in enumerate(_PLANES):
            if number in self._read:
                texture = self._textures[number]
                buffer.addRenderTexture(texture, core.GraphicsOutput.RTMCopyRam, plane)
            buffer.setClearActive(plane, True)
            buffer.setClearValue(plane, core.LVecBase4f(0.0))
        return buffer

    def resolve(self, focal_px: float) -> None:
        """Draw as much detail as a camera of focal length `focal_px` resolves."""
        self._camera.setLodScale(DETAIL.scale_of(focal_px))

    def look_through(self, lens: PinholeCamera) -> None:
        """Use another lens, of the same image size."""
        self.lens = lens
        self._camera.setLens(pinhole_lens(lens))
        self.resolve(lens.focal_px)

    def use_parallel_projection(self, width_m: float, depth_m: float) -> None:
        """Draw without perspective and in full detail; depths are then undefined.

        Parameters
        ----------
        width_m
            Width and height of the picture on the ground, metres.
        depth_m
            Distance up to which things are drawn, metres.
        """
        self._camera.setLens(flat_lens(width_m, width_m, depth_m))
        self._camera.setLodScale(DETAIL.map_scale)

    def expose(self, position_enu: Floats, rotation_enu_from_optical: Floats) -> Rendering:
        """Return what is seen from a pose; what is not its purpose is left empty.

        Parameters
        ----------
        position_enu : (3,)
            Position of the camera, metres.
        rotation_enu_from_optical : (3, 3)
            Rotation of the camera, columns right, down, ahead.
        """
        self._renderer.thread.require()
        self._node.setMat(node_matrix(position_enu, rotation_enu_from_optical))
        self._renderer.graph.sky.setPos(*(float(value) for value in position_enu))
        self._buffer.setActive(True)
        self._engine.renderFrame()
        self._buffer.setActive(False)
        return self._frame()

    def close(self) -> None:
        """Release the buffer."""
        self._engine.removeWindow(self._buffer)
        self._node.removeNode()

    def _plane(self, number: int) -> NDArray[np.uint8]:
        return pixels_of(self._textures[number], self.lens)

    def _frame(self) -> Rendering:
        labels = self._plane(_LABELS)
        numbers = np.bitwise_and(labels.view(np.uint32)[::-1, :, 0], np.uint32(_NUMBER_MASK))
        normals = np.asarray(cv2.flip(cv2.cvtColor(self._plane(_NORMALS), cv2.COLOR_BGRA2RGB), 0))
        image, depth_m, classes = _NO_BYTES, _NO_DEPTH, _NO_BYTES
        if _PICTURE in self._read:
            drawn = cv2.flip(cv2.cvtColor(self._plane(_PICTURE), cv2.COLOR_BGRA2BGR), 0)
            image = smoothed(np.asarray(drawn), numbers, normals)
        if _DEPTH in self._read:
            depth_m = np.ascontiguousarray(self._plane(_DEPTH).view(np.float32)[::-1, :, 0])
            classes = np.asarray(cv2.flip(cv2.extractChannel(labels, _CLASS_BYTE), 0))
        return Rendering(
            image=image, depth_m=depth_m, numbers=numbers, classes=classes, normals=normals
        )

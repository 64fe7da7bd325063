# SPDX-License-Identifier: Apache-2.0
"""The share of each object that other objects do not hide."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from panda3d import core

from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_scene.engine.renderer import Renderer
from rocsafe_scene.engine.scene_graph import ALONE
from rocsafe_scene.engine.shaders import shader
from rocsafe_scene.errors import EngineError
from rocsafe_scene.graphics.lens import NEAR_M, node_matrix, pinhole_lens
from rocsafe_scene.mesh.mesh import Floats

Box = tuple[int, int, int, int]


class Silhouettes:
    """Draws objects alone; objects that do not overlap in the image are drawn together.

    Parameters
    ----------
    renderer
        Renderer of the scene.
    lens
        Intrinsics of the images.
    """

    def __init__(self, renderer: Renderer, lens: PinholeCamera) -> None:
        self._renderer, self._lens = renderer, lens
        self._texture = core.Texture('alone')
        self._buffer = self._make_buffer()
        camera = core.Camera('alone', pinhole_lens(lens))
        camera.setScene(renderer.graph.root)
        camera.setCameraMask(ALONE)
        state = core.NodePath('state')
        state.setShader(shader('alone'), 1000)
        camera.setInitialState(state.getState())
        self._node = renderer.graph.root.attachNewNode(camera)
        self._buffer.makeDisplayRegion().setCamera(self._node)
        self._buffer.setActive(False)

    def _make_buffer(self) -> Any:
        host = self._renderer.pipe.host
        properties = core.FrameBufferProperties()
        properties.setRgbaBits(8, 8, 8, 8)
        properties.setDepthBits(24)
        size = core.WindowProperties.size(self._lens.image_width_px, self._lens.image_height_px)
        buffer = self._renderer.pipe.engine.makeOutput(
            host.getPipe(), 'alone', 0, properties, size, core.GraphicsPipe.BFRefuseWindow,
            host.getGsg(), host,
        )  # fmt: skip
        plane = core.GraphicsOutput.RTPColor
        buffer.addRenderTexture(self._texture, core.GraphicsOutput.RTMCopyRam, plane)
        buffer.setClearActive(plane, True)
        buffer.setClearValue(plane, core.LVecBase4f(0.0))
        return buffer

    def visible_shares(
        self,
        numbers: NDArray[np.uint32],
        bounds: Mapping[int, Floats],
        pose: tuple[Floats, Floats],
    ) -> dict[int, float]:
        """Return the share of each object that no other object hides, 0 to 1.

        Parts outside of the image or under the ground are not counted.

        Parameters
        ----------
        numbers : (height, width)
            Instance numbers of the image taken from the same pose.
        bounds : (2, 3)
            Of the things that are asked for, by number.
        pose
            Position and rotation of the camera.
        """
        seen = np.bincount(numbers.ravel())
        boxes = {number: self._box(corners, *pose) for number, corners in bounds.items()}
        shares = {}
        crowded: dict[int, Box] = {}
        for number, box in boxes.items():
            if _is_apart(number, numbers, box, boxes):
                shares[number] = 1.0
            else:
                crowded[number] = box
        for batch in batches(crowded):
            areas = self._areas(batch, pose)
            shares |= {k: min(1.0, float(seen[k] / max(seen[k], areas[k], 1))) for k in batch}
        return shares

    def _areas(self, batch: Sequence[int], pose: tuple[Floats, Floats]) -> dict[int, int]:
        """Return the number of pixels of each object when only these objects are drawn."""
        things = self._renderer.graph.things
        for number in batch:
            things[number].show(ALONE)
        self._node.setMat(node_matrix(*pose))
        self._buffer.setActive(True)
        self._renderer.pipe.engine.renderFrame()
        self._buffer.setActive(False)
        for number in batch:
            things[number].hide(ALONE)
        data = self._texture.getRamImage()
        if not data:
            raise EngineError('the engine returned no picture')
        raw = np.frombuffer(memoryview(data).cast('B'), np.uint32) & np.uint32(0xFFFFFF)
        counts = np.bincount(raw, minlength=max(batch) + 1)
        return {number: int(counts[number]) for number in batch}

    def _box(self, bounds: Floats, position: Floats, rotation: Floats) -> Box:
        """Return columns and rows (from, to) that contain an object with these bounds."""
        corners = np.array(np.meshgrid(*bounds.T)).reshape(3, -1).T
        optical = (corners - position) @ rotation
        width, height = self._lens.image_width_px, self._lens.image_height_px
        if optical[:, 2].min() <= NEAR_M:
            return 0, 0, width, height
        pixels = optical @ self._lens.matrix.T
        pixels = pixels[:, :2] / pixels[:, 2:]
        low = np.clip(np.floor(pixels.min(axis=0)) - 1, 0, (width, height)).astype(int)
        high = np.clip(np.ceil(pixels.max(axis=0)) + 2, 0, (width, height)).astype(int)
        return int(low[0]), int(low[1]), int(high[0]), int(high[1])


def batches(boxes: Mapping[int, Box]) -> list[list[int]]:
    """Return groups of boxes that do not overlap within a group, largest boxes first."""
    groups: list[list[int]] = []
    for number in sorted(boxes, key=lambda k: (-_area(boxes[k]), k)):
        for group in groups:
            if not any(_overlap(boxes[number], boxes[other]) for other in group):
                group.append(number)
                break
        else:
            groups.append([number])
    return groups


def _is_apart(
    number: int, numbers: NDArray[np.uint32], box: Box, boxes: Mapping[int, Box]
) -> bool:
    """Return whether no other object in the image can hide a part of this one."""
    if any(_overlap(box, other) for k, other in boxes.items() if k != number):
        return False
    left, top, right, bottom = box
    found = np.unique(numbers[top:bottom, left:right])
    return not set(found.tolist()) - {0, 1, number}


def _area(box: Box) -> int:
    return (box[2] - box[0]) * (box[3] - box[1])


def _overlap(one: Box, two: Box) -> bool:
    return one[0] < two[2] and two[0] < one[2] and one[1] < two[3] and two[1] < one[3]

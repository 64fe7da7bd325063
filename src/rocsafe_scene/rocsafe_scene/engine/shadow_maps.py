# SPDX-License-Identifier: Apache-2.0
"""Shadow maps of the sun, and the canopy map that darkens places below foliage."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from panda3d import core

from rocsafe_scene.engine.drawing_options import SHADOWS
from rocsafe_scene.engine.scene_graph import BARE, MOVING, SUN, SceneGraph
from rocsafe_scene.engine.shaders import shader
from rocsafe_scene.graphics.lens import flat_lens, looking, node_matrix
from rocsafe_scene.graphics.pipe import Pipe
from rocsafe_scene.graphics.upload import height_texture
from rocsafe_scene.mesh.mesh import Floats
from rocsafe_scene.scene.sunlight import Lighting

# A camera that looks straight down with north at the top.
_DOWN = np.diag([1.0, -1.0, -1.0])
_TO_TEXTURE = core.LMatrix4f(0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 0.5, 0, 0.5, 0.5, 0.5, 1)


@dataclass(frozen=True, slots=True, eq=False)
class _ShadowMap:
    """Name of a shadow map in the shaders, its buffer, and its camera."""

    name: str
    buffer: Any
    node: Any
    lens: Any


class ShadowMaps:
    """Shadow maps and canopy map of a scene graph, bound to its shaders."""

    def __init__(self, pipe: Pipe, graph: SceneGraph, lighting: Lighting) -> None:
        self._pipe, self._graph = pipe, graph
        self._suns = [
            self._shadow_map('near', SHADOWS.near_m, SHADOWS.near_px),
            self._shadow_map('far', SHADOWS.far_m, SHADOWS.far_px),
        ]
        self._moving: _ShadowMap | None = None
        if graph.has_motion:
            self._moving = self._shadow_map('moving', SHADOWS.near_m, SHADOWS.moving_px, MOVING)
        self._textures: list[Any] = []
        self.relight(lighting)

    def relight(self, lighting: Lighting) -> None:
        """Draw all maps again, after objects or the sun have moved."""
        direction = np.array(lighting.sun_direction)
        for sun in self._suns:
            self._aim(sun, direction)
        if self._moving is not None:
            self._moving.node.setMat(self._suns[0].node.getMat())
        for texture in self._textures:
            texture.releaseAll()
        self._textures.clear()
        self._bind_canopy(np.full((8, 8), -1e3, np.float32))
        self.refresh()
        self._bind_canopy(self._canopy())
        self._graph.inner.setShaderInput('sunlit', self._sunlit())

    def refresh(self) -> None:
        """Draw all shadow maps again."""
        self._draw([*self._suns, *([self._moving] if self._moving else [])])

    def follow(self) -> None:
        """Draw the shadow map of moving objects again."""
        self._draw([self._moving] if self._moving else [])

    def _draw(self, suns: Sequence['_ShadowMap']) -> None:
        for sun in suns:
            sun.buffer.setActive(True)
        self._pipe.engine.renderFrame()
        for sun in suns:
            sun.buffer.setActive(False)

    def _aim(self, sun: '_ShadowMap', direction: Floats) -> None:
        sun.node.setMat(node_matrix(0.5 * SHADOWS.depth_m * direction, looking(-direction)))
        to_clip = self._graph.root.getTransform(sun.node).getMat() * sun.lens.getProjectionMat()
        self._graph.root.setShaderInput(f'{sun.name}_sun', to_clip * _TO_TEXTURE)

    def _shadow_map(self, name: str, width_m: float, size: int, mask: Any = SUN) -> '_ShadowMap':
        texture = core.Texture(f'{name} shadow')
        texture.setFormat(core.Texture.FDepthComponent)
        texture.setMinfilter(core.SamplerState.FTShadow)
        texture.setMagfilter(core.SamplerState.FTShadow)
        # Places beyond the map count as sunlit.
        texture.setWrapU(core.SamplerState.WMBorderColor)
        texture.setWrapV(core.SamplerState.WMBorderColor)
        texture.setBorderColor(core.LVecBase4f(1.0))
        buffer = self._buffer(name, size, size, is_coloured=False)
        buffer.addRenderTexture(
            texture, core.GraphicsOutput.RTMBindOrCopy, core.GraphicsOutput.RTPDepth
        )
        lens = flat_lens(width_m, width_m, SHADOWS.depth_m)
        node = self._camera(buffer, lens, np.zeros(3), _DOWN)
        node.node().setCameraMask(mask)
        buffer.setActive(False)
        self._graph.root.setShaderInput(f'{name}_shadow', texture)
        return _ShadowMap(name, buffer, node, lens)

    def _buffer(self, name: str, width: int, height: int, *, is_coloured: bool = True) -> Any:
        properties = core.FrameBufferProperties()
        if is_coloured:
            properties.setRgbaBits(8, 8, 8, 8)
        properties.setDepthBits(24)
        host = self._pipe.host
        return self._pipe.engine.makeOutput(
            host.getPipe(), name, -50, properties, core.WindowProperties.size(width, height),
            core.GraphicsPipe.BFRefuseWindow, host.getGsg(), host,
        )  # fmt: skip

    def _camera(
        self, buffer: Any, lens: Any, position: Floats, rotation: Floats, drawn_by: str = 'plain'
    ) -> Any:
        camera = core.Camera('from above', lens)
        camera.setScene(self._graph.root)
        camera.setCameraMask(SUN if drawn_by == 'plain' else BARE)
        state = core.NodePath('state')
        state.setShader(shader(drawn_by), 1000)
        state.setTwoSided(True, 1000)
        camera.setInitialState(state.getState())
        node = self._graph.root.attachNewNode(camera)
        node.setMat(node_matrix(position, rotation))
        buffer.makeDisplayRegion().setCamera(node)
        return node

    def _canopy(self) -> Floats:
        """Return the blurred height of objects; far below zero where nothing stands."""
        size = round(2.0 * SHADOWS.canopy_m / SHADOWS.canopy_texel_m)
        buffer = self._buffer('canopy', size, size)
        texture = core.Texture('canopy depth')
        plane = core.GraphicsOutput.RTPColor
        buffer.addRenderTexture(texture, core.GraphicsOutput.RTMCopyRam, plane)
        buffer.setClearActive(plane, True)
        buffer.setClearValue(plane, core.LVecBase4f(0.0))
        lens = flat_lens(2.0 * SHADOWS.canopy_m, 2.0 * SHADOWS.canopy_m, 2.0 * SHADOWS.above_m)
        node = self._camera(buffer, lens, np.array([0.0, 0.0, SHADOWS.above_m]), _DOWN)
        self._pipe.engine.renderFrame()
        raw = np.frombuffer(memoryview(texture.getRamImage()).cast('B'), np.float32)
        depth = raw.reshape(size, size).copy()
        self._pipe.engine.removeWindow(buffer)
        node.removeNode()
        return _blurred(depth)

    def _sunlit(self) -> Any:
        """Return a texture with the shares of sun and sky that reach the inner ground."""
        west, south, width, height = self._graph.inner_area
        size = round(width / SHADOWS.sunlit_texel_m), round(height / SHADOWS.sunlit_texel_m)
        buffer = self._buffer('sunlit', *size)
        texture = core.Texture('sunlit')
        texture.setMinfilter(core.SamplerState.FTLinearMipmapNearest)
        texture.setMagfilter(core.SamplerState.FTLinear)
        plane = core.GraphicsOutput.RTPColor
        buffer.addRenderTexture(texture, core.GraphicsOutput.RTMBindOrCopy, plane)
        lens = flat_lens(width, height, 2.0 * SHADOWS.above_m)
        above = np.array([west + 0.5 * width, south + 0.5 * height, SHADOWS.above_m])
        node = self._camera(buffer, lens, above, _DOWN, 'sunlit')
        self._pipe.engine.renderFrame()
        self._pipe.engine.removeWindow(buffer)
        node.removeNode()
        self._textures.append(texture)
        return texture

    def _bind_canopy(self, heights: Floats) -> None:
        texture = height_texture('canopy', heights)
        self._textures.append(texture)
        self._graph.root.setShaderInput('canopy', texture)
        area = core.LVecBase4f(
            -SHADOWS.canopy_m, -SHADOWS.canopy_m, 0.5 / SHADOWS.canopy_m, 0.5 / SHADOWS.canopy_m
        )
        self._graph.root.setShaderInput('canopy_area', area)


def _blurred(depth: Floats) -> Floats:
    """Return the mean height of objects around each place, from the depth seen from above."""
    is_bare = depth <= 0.0
    height = np.where(is_bare, 0.0, SHADOWS.above_m - depth).astype(np.float32)
    cover = (~is_bare).astype(np.float32)
    sigma = SHADOWS.canopy_blur_m / SHADOWS.canopy_texel_m
    weight = cv2.GaussianBlur(cover, (0, 0), sigma)
    mean = cv2.GaussianBlur(height * cover, (0, 0), sigma) / np.maximum(weight, 1e-3)
    # Sparse cover hides little of the sky. Cover falls to none where the blur ends, so that no
    # edge shows there.
    sunk = 5.0 * (1.0 - weight) + 18.0 * np.maximum(0.0, 1.0 - weight / 0.3)
    return np.asarray(np.where(weight > 0.02, mean - sunk, -1e3), np.float32)

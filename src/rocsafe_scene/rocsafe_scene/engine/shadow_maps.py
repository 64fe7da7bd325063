# SPDX-License-Identifier: Apache-2.0
"""What the sun and the sky do not reach: shadow maps, and the canopy seen from above."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from panda3d import core

from rocsafe_scene.engine.scene_graph import BARE, MOVING, SUN, SceneGraph
from rocsafe_scene.engine.shaders import shader
from rocsafe_scene.graphics.lens import flat_lens, looking, node_matrix
from rocsafe_scene.graphics.pipe import Pipe
from rocsafe_scene.graphics.upload import height_texture
from rocsafe_scene.mesh.mesh import Floats
from rocsafe_scene.scene.sunlight import Lighting

# Width of the shadow maps on the ground, metres and texels.
_NEAR_M, _NEAR_PX = 360.0, 4096
_FAR_M, _FAR_PX = 1100.0, 2048
# Texels of the map of what moves, as wide as the near one.
_MOVING_PX = 3072
_DEPTH_M = 900.0
# The canopy: half extent, texel and blur, metres; from above everything.
_CANOPY_M, _CANOPY_TEXEL_M, _BLUR_M, _ABOVE_M = 180.0, 0.5, 1.3, 400.0
# Texel of the light on the ground, metres.
_SUNLIT_TEXEL_M = 0.12
# A camera that looks straight down with north at the top.
_DOWN = np.diag([1.0, -1.0, -1.0])
_TO_TEXTURE = core.LMatrix4f(0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 0.5, 0, 0.5, 0.5, 0.5, 1)


@dataclass(frozen=True, slots=True, eq=False)
class _ShadowMap:
    """A shadow map's name in the shaders, its buffer, and the camera it is drawn by."""

    name: str
    buffer: Any
    node: Any
    lens: Any


class ShadowMaps:
    """Shadow maps and canopy of a stage, bound to its shaders."""

    def __init__(self, pipe: Pipe, graph: SceneGraph, lighting: Lighting) -> None:
        self._pipe, self._graph = pipe, graph
        self._suns = [
            self._shadow_map('near', _NEAR_M, _NEAR_PX),
            self._shadow_map('far', _FAR_M, _FAR_PX),
        ]
        self._moving: _ShadowMap | None = None
        if graph.has_motion:
            self._moving = self._shadow_map('moving', _NEAR_M, _MOVING_PX, MOVING)
        self._textures: list[Any] = []
        self.relight(lighting)

    def relight(self, lighting: Lighting) -> None:
        """Draw all shade anew, after things were put elsewhere or the sun has moved."""
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
        """Draw the shadows of what moves again; those of what stands are as they were."""
        self._draw([self._moving] if self._moving else [])

    def _draw(self, suns: Sequence['_ShadowMap']) -> None:
        for sun in suns:
            sun.buffer.setActive(True)
        self._pipe.engine.renderFrame()
        for sun in suns:
            sun.buffer.setActive(False)

    def _aim(self, sun: '_ShadowMap', direction: Floats) -> None:
        sun.node.setMat(node_matrix(0.5 * _DEPTH_M * direction, looking(-direction)))
        to_clip = self._graph.root.getTransform(sun.node).getMat() * sun.lens.getProjectionMat()
        self._graph.root.setShaderInput(f'{sun.name}_sun', to_clip * _TO_TEXTURE)

    def _shadow_map(self, name: str, width_m: float, size: int, mask: Any = SUN) -> '_ShadowMap':
        texture = core.Texture(f'{name} shadow')
        texture.setFormat(core.Texture.FDepthComponent)
        texture.setMinfilter(core.SamplerState.FTShadow)
        texture.setMagfilter(core.SamplerState.FTShadow)
        # Nothing is known beyond the map: sunlit.
        texture.setWrapU(core.SamplerState.WMBorderColor)
        texture.setWrapV(core.SamplerState.WMBorderColor)
        texture.setBorderColor(core.LVecBase4f(1.0))
        buffer = self._buffer(name, size, size, is_coloured=False)
        buffer.addRenderTexture(
            texture, core.GraphicsOutput.RTMBindOrCopy, core.GraphicsOutput.RTPDepth
        )
        lens = flat_lens(width_m, width_m, _DEPTH_M)
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
        """Return the height of what stands on the ground, blurred; far below where nothing is."""
        size = round(2.0 * _CANOPY_M / _CANOPY_TEXEL_M)
        buffer = self._buffer('canopy', size, size)
        texture = core.Texture('canopy depth')
        plane = core.GraphicsOutput.RTPColor
        buffer.addRenderTexture(texture, core.GraphicsOutput.RTMCopyRam, plane)
        buffer.setClearActive(plane, True)
        buffer.setClearValue(plane, core.LVecBase4f(0.0))
        lens = flat_lens(2.0 * _CANOPY_M, 2.0 * _CANOPY_M, 2.0 * _ABOVE_M)
        node = self._camera(buffer, lens, np.array([0.0, 0.0, _ABOVE_M]), _DOWN)
        self._pipe.engine.renderFrame()
        raw = np.frombuffer(memoryview(texture.getRamImage()).cast('B'), np.float32)
        depth = raw.reshape(size, size).copy()
        self._pipe.engine.removeWindow(buffer)
        node.removeNode()
        return _blurred(depth)

    def _sunlit(self) -> Any:
        """Return how much sun and sky each place of the inner ground gets, drawn once."""
        west, south, width, height = self._graph.inner_area
        size = round(width / _SUNLIT_TEXEL_M), round(height / _SUNLIT_TEXEL_M)
        buffer = self._buffer('sunlit', *size)
        texture = core.Texture('sunlit')
        texture.setMinfilter(core.SamplerState.FTLinearMipmapNearest)
        texture.setMagfilter(core.SamplerState.FTLinear)
        plane = core.GraphicsOutput.RTPColor
        buffer.addRenderTexture(texture, core.GraphicsOutput.RTMBindOrCopy, plane)
        lens = flat_lens(width, height, 2.0 * _ABOVE_M)
        above = np.array([west + 0.5 * width, south + 0.5 * height, _ABOVE_M])
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
        area = core.LVecBase4f(-_CANOPY_M, -_CANOPY_M, 0.5 / _CANOPY_M, 0.5 / _CANOPY_M)
        self._graph.root.setShaderInput('canopy_area', area)


def _blurred(depth: Floats) -> Floats:
    """Return heights that say how much sky is hidden at a place: mean over its neighbourhood."""
    is_bare = depth <= 0.0
    height = np.where(is_bare, 0.0, _ABOVE_M - depth).astype(np.float32)
    cover = (~is_bare).astype(np.float32)
    sigma = _BLUR_M / _CANOPY_TEXEL_M
    weight = cv2.GaussianBlur(cover, (0, 0), sigma)
    mean = cv2.GaussianBlur(height * cover, (0, 0), sigma) / np.maximum(weight, 1e-3)
    # Sparse cover hides little, and none where the blur ends, which would show as an edge.
    sunk = 5.0 * (1.0 - weight) + 18.0 * np.maximum(0.0, 1.0 - weight / 0.3)
    return np.asarray(np.where(weight > 0.02, mean - sunk, -1e3), np.float32)

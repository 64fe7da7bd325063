# SPDX-License-Identifier: Apache-2.0
"""Methods of time and of drawings."""

import asyncio
from collections.abc import Mapping
from typing import Any

from rocsafe_airsim.errors import AirsimError
from rocsafe_airsim.methods.access import LONGEST_TEXT, Access, parameters, pen, served
from rocsafe_airsim.methods.given import number, sequence, table
from rocsafe_airsim.methods.given_motion import LONGEST_S, vector_of
from rocsafe_airsim.methods.moving import NS_PER_S, POLL_S
from rocsafe_airsim.ned import Vector
from rocsafe_geo.pinhole import rotation_of_quaternion

# Colours of ahead, right, down.
_AXES = ((1.0, 0.0, 0.0, 1.0), (0.0, 1.0, 0.0, 1.0), (0.0, 0.0, 1.0, 1.0))


class WorldMethods:
    """Time and drawings."""

    def __init__(self, at: Access) -> None:
        self._at = at

    @served('simPause')
    async def _sim_pause(self, is_paused: bool) -> None:
        await self._at.world.pause(is_paused=bool(is_paused))

    @served('simIsPaused')
    async def _sim_is_paused(self) -> bool:
        return self._at.world.is_paused()

    @served('simContinueForTime')
    async def _sim_continue_for_time(self, seconds: float) -> None:
        lasting_s = number(seconds, 'seconds')
        if not 0.0 <= lasting_s <= LONGEST_S:
            raise AirsimError(f'seconds is {lasting_s:g}: must be within 0 and {LONGEST_S:g}')
        end_ns = self._at.world.time_ns() + round(lasting_s * NS_PER_S)
        await self._at.world.pause(is_paused=False)
        while self._at.world.time_ns() < end_ns:
            await asyncio.sleep(POLL_S / 4.0)
        await self._at.world.pause(is_paused=True)

    @served('simPlotPoints')
    async def _sim_plot_points(self, *call: Any) -> None:
        points, rgba, size, duration_s, is_lasting = parameters(call, 5)[:5]
        self._at.draw([_places(points)], rgba, size, 'points', (duration_s, is_lasting))

    @served('simPlotLineStrip')
    async def _sim_plot_line_strip(self, *call: Any) -> None:
        points, rgba, size, duration_s, is_lasting = parameters(call, 5)[:5]
        self._at.draw([_places(points)], rgba, size, 'lines', (duration_s, is_lasting))

    @served('simPlotLineList')
    async def _sim_plot_line_list(self, *call: Any) -> None:
        points, rgba, size, duration_s, is_lasting = parameters(call, 5)[:5]
        ends = _places(points)
        pairs = [list(pair) for pair in zip(ends[::2], ends[1::2], strict=False)]
        self._at.draw(pairs, rgba, size, 'lines', (duration_s, is_lasting))

    @served('simPlotArrows')
    async def _sim_plot_arrows(self, *call: Any) -> None:
        starts, ends, rgba, size, _head, duration_s, is_lasting = parameters(call, 7)[:7]
        pairs = [list(pair) for pair in _pairs(_places(starts), _places(ends))]
        self._at.draw(pairs, rgba, size, 'lines', (duration_s, is_lasting))

    @served('simPlotTransforms')
    async def _sim_plot_transforms(self, *call: Any) -> None:
        poses, scale, thickness, duration_s, is_lasting = parameters(call, 5)[:5]
        for axis, rgba in enumerate(_AXES):
            lines = [_axis(one, axis, number(scale, 'scale')) for one in _poses(poses)]
            self._at.draw(lines, rgba, thickness, 'lines', (duration_s, is_lasting))

    @served('simPlotStrings')
    async def _sim_plot_strings(self, *call: Any) -> None:
        texts, places, scale, rgba, duration_s = parameters(call, 5)[:5]
        self._write(texts, _places(places), rgba, scale, duration_s)

    @served('simPlotTransformsWithNames')
    async def _sim_plot_transforms_with_names(self, *call: Any) -> None:
        poses, names, scale, thickness, letters, rgba, duration_s = parameters(call, 7)[:7]
        await self._sim_plot_transforms(poses, scale, thickness, duration_s, False)
        places = [vector_of(one.get('position')) for one in _poses(poses)]
        self._write(names, places, rgba, letters, duration_s)

    def _write(
        self, texts: Any, places: list[Vector], rgba: Any, scale: Any, duration_s: Any
    ) -> None:
        pairs = _pairs(sequence(texts, 'strings'), places)
        self._at.write([one for one, _ in pairs], places, rgba, scale, duration_s)

    @served('simSetTraceLine')
    async def _sim_set_trace_line(self, rgba: Any, thickness: float = 1.0, name: str = '') -> None:
        self._at.world.drawings.trace(self._at.vehicle(name).name, *pen(rgba, thickness))

    @served('simFlushPersistentMarkers')
    async def _sim_flush_persistent_markers(self) -> None:
        self._at.world.drawings.clear()

    @served('simPrintLogMessage')
    async def _sim_print_log_message(
        self, message: str, parameter: str = '', _severity: int = 0
    ) -> None:
        self._at.tell(' '.join(f'{message}{parameter}'[:LONGEST_TEXT].split()))


def _places(points: Any) -> list[Vector]:
    return [vector_of(one) for one in sequence(points, 'points')]


def _poses(poses: Any) -> list[Mapping[str, Any]]:
    return [table(one, 'a pose') for one in sequence(poses, 'poses')]


def _pairs(ones: list[Any], others: list[Any]) -> list[tuple[Any, Any]]:
    if len(ones) != len(others):
        raise AirsimError(f'{len(ones)} and {len(others)} elements: must be as many')
    return list(zip(ones, others, strict=True))


def _axis(pose: Mapping[str, Any], axis: int, scale: float) -> list[Vector]:
    """Return both ends of an axis of a pose, `scale` hundredths of a metre long."""
    place, turned = vector_of(pose.get('position')), table(pose.get('orientation'), 'orientation')
    w, x, y, z = (number(turned.get(f'{part}_val'), f'{part}_val') for part in 'wxyz')
    ahead = rotation_of_quaternion((x, y, z, w))[:, axis] * (scale / 100.0)
    north, east, down = (a + float(b) for a, b in zip(place, ahead, strict=True))
    return [place, (north, east, down)]

# SPDX-License-Identifier: Apache-2.0
"""How fast, how large and how exact the engine draws a scene; targets beside the figures.

    python benchmarks/rendering.py [--scene config/scenes/derailment.yaml] [--frames 8] [--large]
    python benchmarks/rendering.py --growth 10000      # memory after so many frames
    ROCSAFE_RENDERER=software python benchmarks/rendering.py        # without EGL

CPU time is that of the process over all its threads; wall time depends on what else runs. The
scene is drawn with all outputs read back: picture, depth, instances, classes and normals.
"""

import argparse
import math
import os
import resource
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from rocsafe_geo.pinhole import PinholeCamera, rotation_enu_from_optical
from rocsafe_scene.engine.oversampled_camera import AnyRenderer, open_renderer
from rocsafe_scene.graphics.lens import looking
from rocsafe_scene.mesh.mesh import Floats
from rocsafe_scene.scene.building import build
from rocsafe_scene.scene.map_cache import default_folder
from rocsafe_scene.scene.scene_file import read_scene

SCENE = Path(__file__).resolve().parents[1] / 'config' / 'scenes' / 'derailment.yaml'
OBLIQUE_EYE = np.array([-10.0, -38.0, 24.0])
POSES: dict[str, tuple[Floats, Floats]] = {
    'nadir': (np.array([10.0, 8.0, 32.0]), rotation_enu_from_optical(0.25)),
    'oblique': (OBLIQUE_EYE, looking(np.array([16.0, 12.0, 0.0]) - OBLIQUE_EYE)),
}
WARM_UP_FRAMES = 2


@dataclass(frozen=True, slots=True)
class Case:
    """A size, a pose, and the frames a second to be had on two idle cores without a GPU."""

    width_px: int
    height_px: int
    pose: str
    target_fps: float


CASES = (
    Case(640, 480, 'nadir', 20.0),
    Case(640, 480, 'oblique', 15.0),
    Case(1920, 1080, 'nadir', 7.0),
    Case(1920, 1080, 'oblique', 7.0),
)
LARGE = Case(4000, 3000, 'nadir', 1.25)
SOFTWARE_CASES = (Case(640, 480, 'nadir', 10.0), Case(640, 480, 'oblique', 10.0))
GPU_FPS = 200.0
WARM_START_S, COLD_START_S = 5.0, 40.0
MOST_GB, MOST_GB_LARGE = 1.2, 2.0
# Frames before memory is looked at, and what may be added to it by all after them.
SETTLING_FRAMES, GROWTH_MB = 200, 20.0


def main(argv: Sequence[str] | None = None) -> int:
    """Measure and print; return 0."""
    parser = argparse.ArgumentParser(description=(__doc__ or '').splitlines()[0])
    parser.add_argument('--scene', type=Path, default=SCENE)
    parser.add_argument('--frames', type=int, default=8, help='a case (default: 8)')
    parser.add_argument('--large', action='store_true', help='also 4000 x 3000 px')
    parser.add_argument('--growth', type=int, default=0, metavar='N', help='draw N frames more')
    arguments = parser.parse_args(argv)
    console = Console()
    renderer = _start(arguments.scene, console)
    console.print(_timed(renderer, _cases(renderer, is_large=arguments.large), arguments.frames))
    most = MOST_GB_LARGE if arguments.large else MOST_GB
    console.print(
        f'{renderer.pipe.renderer}; {os.cpu_count()} processors, load {os.getloadavg()[0]:.1f}; '
        f'memory at most {memory_gb():.2f} GB (<= {most:g} GB: {verdict(memory_gb() <= most)})'
    )
    if arguments.growth:
        start, middle, end = growth_mb(renderer, arguments.growth)
        console.print(
            f'{arguments.growth} frames: {start:.0f} MB at the start, {middle:.0f} amid, '
            f'{end:.0f} at the end (+ <= {GROWTH_MB:g} MB: {verdict(end - start <= GROWTH_MB)})'
        )
    return 0


def _cases(renderer: AnyRenderer, *, is_large: bool) -> tuple[Case, ...]:
    """Return what is to be measured, with the goals for what draws here."""
    if renderer.pipe.is_degraded:
        return SOFTWARE_CASES
    cases = (*CASES, *((LARGE,) if is_large else ()))
    if 'llvmpipe' in renderer.pipe.renderer:
        return cases
    return tuple(replace(case, target_fps=GPU_FPS) if case.width_px == 640 else case
                 for case in cases)  # fmt: skip


def _timed(renderer: AnyRenderer, cases: Sequence[Case], frames: int) -> Table:
    table = Table('size', 'view', 'CPU ms', 'wall ms', 'frames/s', 'goal', '')
    for case in cases:
        cpu_s, wall_s = measured(renderer, case, frames)
        table.add_row(
            f'{case.width_px} x {case.height_px}', case.pose, f'{1e3 * cpu_s:.0f}',
            f'{1e3 * wall_s:.0f}', f'{1.0 / wall_s:.1f}', f'>= {case.target_fps:g}',
            verdict(1.0 / wall_s >= case.target_fps),
        )  # fmt: skip
    return table


def verdict(is_met: bool) -> str:
    """Return a word for whether a goal is met."""
    return 'met' if is_met else 'missed'


def _start(scene: Path, console: Console) -> AnyRenderer:
    """Return a renderer of `scene`, saying how long it took to be ready."""
    description = read_scene(scene)
    wall, cpu = time.perf_counter(), time.process_time()
    environment = build(description, cache=default_folder())
    renderer = open_renderer(environment, description)
    renderer.camera(PinholeCamera(1.0, 64, 48)).expose(*POSES['nadir'])
    ready_s = time.perf_counter() - wall
    triangles = sum(thing.triangle_count for thing in environment.objects)
    console.print(
        f'{description.name}: {len(environment.objects)} objects, {triangles} '
        f'triangles; ready in {ready_s:.1f} s wall, {time.process_time() - cpu:.1f} s CPU '
        f'(from a warm cache <= {WARM_START_S:g} s: {verdict(ready_s <= WARM_START_S)}; '
        f'cold <= {COLD_START_S:g} s: {verdict(ready_s <= COLD_START_S)})'
    )
    return renderer


def measured(renderer: AnyRenderer, case: Case, frames: int) -> tuple[float, float]:
    """Return CPU and wall time of a frame, s."""
    eye = renderer.camera(PinholeCamera(math.radians(60.0), case.width_px, case.height_px))
    for _ in range(WARM_UP_FRAMES):
        eye.expose(*POSES[case.pose])
    wall, cpu = time.perf_counter(), time.process_time()
    for _ in range(frames):
        eye.expose(*POSES[case.pose])
    found = (time.process_time() - cpu) / frames, (time.perf_counter() - wall) / frames
    eye.close()
    return found


def growth_mb(renderer: AnyRenderer, frames: int) -> list[float]:
    """Return the memory before, amid and after `frames` drawn from all around, MB."""
    eye = renderer.camera(PinholeCamera(math.radians(60.0), 160, 120))
    found = []
    for number in range(SETTLING_FRAMES + frames):
        if number in (SETTLING_FRAMES, SETTLING_FRAMES + frames // 2):
            found.append(resident_mb())
        turn = 2.399963 * number
        place = np.array([60.0 * math.cos(turn), 60.0 * math.sin(turn), 32.0])
        eye.expose(place, POSES['oblique' if number % 2 else 'nadir'][1])
    eye.close()
    return [*found, resident_mb()]


def resident_mb() -> float:
    """Return the memory this process has now."""
    pages = int(Path('/proc/self/statm').read_text().split()[1])
    return pages * resource.getpagesize() / 1e6


def memory_gb() -> float:
    """Return the largest memory this process had."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e9


if __name__ == '__main__':
    sys.exit(main())

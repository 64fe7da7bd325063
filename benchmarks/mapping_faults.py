# SPDX-License-Identifier: Apache-2.0
"""The case of faulty photographs and sensors."""

import argparse
import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from mapping_figures import (
    Measured,
    Row,
    mapped,
    real_ground,
)
from mapping_sets import (
    Flight,
    Orthophoto,
    Sample,
    flown,
    moved,
    turned,
)


def robust(options: argparse.Namespace) -> list[Row]:
    """What goes wrong in the field.

    The error of one map is mostly where all of it lies: a single draw, which is less than half of
    its standard deviation for one map in five. So flights with several seeds are taken together.
    """
    ground = real_ground(options)
    made: dict[str, list[Measured]] = {}
    for seed in range(21, 21 + options.seeds):
        for name, samples in _robust_cases(ground, seed).items():
            made.setdefault(name, []).append(mapped(samples, ground.frame))
    return [
        (name, _robust_text(flights), 'all on the map; ratio 0.5 to 2')
        for name, flights in made.items()
    ]


def _robust_cases(ground: Orthophoto, seed: int) -> dict[str, list[Sample]]:
    """Return one flight with each of the faults."""
    usual = flown(ground, Flight(), seed)
    rng = np.random.default_rng(seed)
    some = set(rng.choice(len(usual), max(1, len(usual) // 10), replace=False).tolist())
    frame = ground.frame
    half = len(usual) // 2
    return {
        'usual': usual,
        '10 % fixes 20 m off': [
            moved(s, frame, 20.0, 0.0) if n in some else s for n, s in enumerate(usual)
        ],
        'half of the yaws reversed': [
            turned(s, math.pi) if n % 2 else s for n, s in enumerate(usual)
        ],
        'one drone 1 s late (8 m/s)': [
            _of_second_drone(moved(s, frame, 8.0 * (-1) ** (n // 4), 0.0)) if n < half else s
            for n, s in enumerate(usual)
        ],
        '20 % of the images lost': [s for n, s in enumerate(usual) if n % 5],
        'exposure 1 stop apart': [_darker(s) if n % 2 else s for n, s in enumerate(usual)],
        'water: no features in 3': [
            _blank(s) if n in (3, 7, 8) else s for n, s in enumerate(usual)
        ],
        'focal length 6 % off, not calibrated': [_uncalibrated(s) for s in usual],
    }


def _robust_text(flights: Sequence[Measured]) -> str:
    def rms(name: str) -> float:
        return math.sqrt(float(np.mean([getattr(made, name) ** 2 for made in flights])))

    refused = sorted({made.refused for made in flights if made.refused})
    text = (
        f'{sum(made.tied for made in flights)} of {sum(made.total for made in flights)} tied in '
        f'{len(flights)} flights, off {rms("absolute_m"):.2f} m, stated {rms("stated_m"):.2f} m '
        f'(ratio {rms("stated_m") / rms("absolute_m"):.2f}), internal {rms("internal_m"):.2f} m'
    )
    return text + (f'; refused: {"; ".join(refused)}' if refused else '')


def _of_second_drone(sample: Sample) -> Sample:
    record = sample.record
    name = f'rav2-{record.sequence:05d}'
    return replace(sample, record=replace(record, vehicle='rav2', shot_id=name))


def _darker(sample: Sample) -> Sample:
    import cv2

    picture = cv2.imdecode(np.frombuffer(sample.jpeg, np.uint8), cv2.IMREAD_COLOR) // 2
    return replace(sample, jpeg=bytes(cv2.imencode('.jpg', picture)[1]))


def _blank(sample: Sample) -> Sample:
    import cv2

    camera = sample.record.camera
    picture = np.full((camera.height_px, camera.width_px, 3), 90, np.uint8)
    return replace(sample, jpeg=bytes(cv2.imencode('.jpg', picture)[1]))


def _uncalibrated(sample: Sample) -> Sample:
    camera = sample.record.camera
    wrong = replace(
        camera, fx_px=1.06 * camera.fx_px, fy_px=1.06 * camera.fy_px, focal_std_share=0.06
    )
    return replace(sample, record=replace(sample.record, camera=wrong))

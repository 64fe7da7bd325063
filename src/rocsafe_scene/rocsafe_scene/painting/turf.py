# SPDX-License-Identifier: Apache-2.0
"""The meadow below all marks: its colours, tufts and centimetre detail."""

import cv2
import numpy as np

from rocsafe_geo.arrays import ImageArray
from rocsafe_scene.painting.noise import Field, Window, fractal_at

# Amplitudes by octave, of spacing 2^k cm.
_TONE = {7: 0.5, 8: 0.7, 9: 0.8, 10: 1.0, 11: 1.1, 12: 1.2, 13: 1.0}
_DRYNESS = {6: 0.5, 7: 0.7, 8: 0.9, 9: 0.8, 10: 0.8, 11: 1.0, 12: 1.0}
_TUFTS = {4: 0.8, 5: 0.9, 6: 0.7, 7: 0.5}
_DETAIL = {0: 0.9, 1: 1.0, 2: 1.1, 3: 0.9, 4: 0.4}
_GRAIN = 120

# From dark, lush grass over meadow to dry stalks: red, green, blue.
_LUSH = ((46, 72, 33), (62, 92, 42), (80, 109, 50), (99, 124, 60), (116, 134, 72))
_DRY = ((84, 92, 52), (103, 108, 62), (124, 123, 73), (142, 136, 86), (158, 148, 100))


def turf(seed: int, octave: int, window: Window) -> ImageArray:
    """Return colours (blue, green, red) and grain of bare meadow, shape (rows, columns, 4)."""
    tone = fractal_at(seed + 1, _TONE, octave, window)
    tufts = fractal_at(seed + 2, _TUFTS, octave, window)
    dryness = fractal_at(seed + 3, _DRYNESS, octave, window)
    index = _bytes(cv2.addWeighted(tone, 0.16, tufts, 0.15, 0.46))
    lush, dry = (cv2.LUT(cv2.merge([index] * 3), table) for table in (_LUSH_TABLE, _DRY_TABLE))
    share = np.clip(cv2.addWeighted(dryness, 0.45, dryness, 0.0, 0.18), 0.0, 0.85)
    colours = cv2.blendLinear(lush, dry, 1.0 - share, share)
    return cv2.merge([*cv2.split(colours), np.full(window.shape, _GRAIN, np.uint8)])


def detail(seed: int, octave: int, window: Window) -> Field:
    """Return the centimetre texture of all surfaces, about -1 to 1."""
    return fractal_at(seed + 4, _DETAIL, octave, window)


def _bytes(values: Field) -> ImageArray:
    return cv2.multiply(cv2.max(values, 0.0), 255.0, dtype=cv2.CV_8U)


def _table(stops: tuple[tuple[int, int, int], ...]) -> ImageArray:
    """Return a look-up table (1, 256, 3), blue first, through evenly spaced colours."""
    at = np.linspace(0.0, 255.0, len(stops))
    channels = [np.interp(np.arange(256.0), at, [s[part] for s in stops]) for part in (2, 1, 0)]
    return np.stack(channels, axis=-1).astype(np.uint8)[None]


_LUSH_TABLE = _table(_LUSH)
_DRY_TABLE = _table(_DRY)

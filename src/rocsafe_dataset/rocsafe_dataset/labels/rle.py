# SPDX-License-Identifier: Apache-2.0
"""Masks as run lengths in COCO's two notations: numbers and compressed text."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Mask = NDArray[np.bool_]


def run_lengths(mask: Mask) -> list[int]:
    """Return the lengths of alternating runs of 0 and 1, starting with 0, column by column."""
    flat = np.ascontiguousarray(mask.T).ravel()
    changes = np.flatnonzero(flat[1:] != flat[:-1]) + 1
    bounds = np.concatenate([[0], changes, [flat.size]])
    lengths = np.diff(bounds).tolist()
    return [0, *lengths] if flat.size and flat[0] else lengths


def short_text(lengths: Sequence[int]) -> str:
    """Return run lengths as COCO's compressed text (rleToString of the COCO API).

    From the fourth on, a length is written as its difference to the last but one. Numbers are
    written in groups of 5 bits, the lowest first; 32 is added while more follow, and 48 makes a
    printable character.
    """
    parts = []
    for index, length in enumerate(lengths):
        value = length - lengths[index - 2] if index > 2 else length
        while True:
            group = value & 0x1F
            value >>= 5
            is_last = value == (-1 if group & 0x10 else 0)
            parts.append(chr(48 + (group if is_last else group | 0x20)))
            if is_last:
                break
    return ''.join(parts)

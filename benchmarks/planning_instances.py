# SPDX-License-Identifier: Apache-2.0
"""Instances that plans are measured on, and the best that others have published for them."""

import csv
import os
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

# mTSPLib: least of CPLEX, OR-Tools and NCE as published (Kim, Park and Park, 2023, table A.4), and
# of a prototype of this search. Of rat99 with 7 NCE's 441.6 is the least; the farthest trip alone
# is 436.44.
MTSPLIB = {
    'eil51': {2: 222.73, 3: 159.57, 5: 118.13, 7: 112.07},
    'berlin52': {2: 4110.21, 3: 3069.59, 5: 2440.92, 7: 2440.92},
    'eil76': {2: 280.85, 3: 195.72, 5: 142.88, 7: 127.56},
    'rat99': {2: 665.99, 3: 517.72, 5: 450.5, 7: 441.6},
}
TSPLIB = {
    'mtsp51': (3, 5, 10),
    'mtsp100': (3, 5, 10),
    'rand100': (3, 5, 10),
    'kroa200': (3, 5, 10),
    'lin318': (3, 5, 10),
    'rat783': (3, 5, 10),
    'pcb1173': (3, 5, 10),
}


class AbsentError(Exception):
    """Data or a library are not there."""


def data_folder() -> Path | None:
    """Return where the instances are, if they are there."""
    shared = os.environ.get('ROCSAFE_SHARED')
    folder = Path(shared or 'shared') / 'data' / 'mtsp'
    return folder if folder.is_dir() else None


def instance(name: str) -> Floats:
    """Return the points of an instance, depot first; `grid20` is 20 x 20 points from a corner."""
    if name.startswith('grid'):
        side = range(int(name[4:]))
        return np.array([(x, y) for x in side for y in side], np.float64)
    folder = data_folder()
    if folder is None:
        raise AbsentError('ROCSAFE_SHARED names no folder with data/mtsp')
    lines = (folder / f'{name}.tsp').read_text().split('NODE_COORD_SECTION')[1].splitlines()
    rows = [line.split() for line in lines]
    return np.array([row[1:3] for row in rows if len(row) == 3], np.float64)


def published(name: str, vehicles: int) -> float:
    """Return the least published value of an instance."""
    folder = data_folder()
    if folder is None:
        raise AbsentError('ROCSAFE_SHARED names no folder with data/mtsp')
    with (folder / 'best_known.csv').open() as stream:
        return min(
            float(row['objective_best'])
            for row in csv.DictReader(stream)
            if row['instance'].lower() == name
            and row['m'] == str(vehicles)
            and row['method'] in ('MA', 'HSNR')
        )

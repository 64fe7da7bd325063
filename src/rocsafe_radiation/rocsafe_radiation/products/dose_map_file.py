# SPDX-License-Identifier: Apache-2.0
"""A dose map as a GeoTIFF of 32-bit floats."""

from collections.abc import Sequence
from pathlib import Path

from rocsafe_geo.frame import LocalFrame
from rocsafe_hazard.grid_file import Band, write_grid
from rocsafe_radiation.products.dose_map import DoseMap


def write_dose_map(
    path: Path, found: DoseMap, frame: LocalFrame, doubts: Sequence[str] = ()
) -> None:
    """Write mean, standard deviation and upper 95 % of `found`, each microsievert per hour.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    bands = (
        Band(meaning='mean: dose rate 1 m above ground, uSv/h', values=found.mean_usvh),
        Band(meaning='std: standard deviation of the mean, uSv/h', values=found.std_usvh),
        Band(meaning='upper_95: upper 95 % of the dose rate, uSv/h', values=found.upper_usvh),
    )
    write_grid(path, bands, found.corner_m, found.cell_m, frame, doubts)

# SPDX-License-Identifier: Apache-2.0
"""Find gamma sources in a CSV file of east, north, up (metres) and counts of one second each.

python examples/localise_readings.py counts.csv 100
"""

import sys

import numpy as np

from rocsafe_radiation.localization.estimates import Localization
from rocsafe_radiation.localization.localize import localize
from rocsafe_radiation.readings.survey import RadiationSurvey


def main(path: str, counts_per_usvh: float) -> Localization:
    """Print the sources; `rocsafe localize` does it for other columns and units.

    Parameters
    ----------
    path
        CSV file without a head: east, north, height above the ground, counts.
    counts_per_usvh
        What the detector counts in a second at 1 uSv/h.
    """
    table = np.loadtxt(path, delimiter=',')
    survey = RadiationSurvey(
        positions_enu_m=table[:, :3],
        counts=table[:, 3],
        exposures=np.full(len(table), counts_per_usvh),
    )
    found = localize(survey)
    for source in found.sources:
        east, north, _ = source.position_enu_m
        print(f'source at east {east:.1f} m, north {north:.1f} m')
    print(f'{len(found.sources)} sources in {len(table)} readings')
    return found


if __name__ == '__main__':
    main(sys.argv[1], float(sys.argv[2]))

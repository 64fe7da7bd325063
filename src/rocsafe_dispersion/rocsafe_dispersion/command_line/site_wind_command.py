# SPDX-License-Identifier: Apache-2.0
"""The command `site-wind`: how buildings and ground change the wind, from a file of solids."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from rocsafe_dispersion.buildings.building_wind import building_wind
from rocsafe_dispersion.buildings.site_box import SMALLEST_CELL_M, site_box
from rocsafe_geo.solids.solids_file import read_solids
from rocsafe_geo.wind.mission_wind import LEAST_WIND_MPS, WindSettings
from rocsafe_geo.wind.site_wind import SitePattern
from rocsafe_geo.wind.site_wind_file import write_pattern
from rocsafe_geo.wind.stability import CLASSES
from rocsafe_geo.wind.wind_field import ProfileWind
from rocsafe_geo.wind.wind_vector import WindVector


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; return 0, or 2 if something is wrong, after one line that says what."""
    arguments = parser().parse_args(argv)
    try:
        pattern = _pattern(arguments)
        write_pattern(arguments.out, pattern)
    except (OSError, ValueError) as error:
        sys.stderr.write(f'rocsafe: {error}\n')
        return 2
    grid = pattern.grid
    size = ' x '.join(map(str, grid.shape))
    text = f'{arguments.out}: {size} cells of {grid.cell_m:g} x {grid.layer_m:g} m\n'
    sys.stdout.write(text)
    return 0


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    found = argparse.ArgumentParser(
        prog='rocsafe site-wind',
        description='Compute how buildings and ground of a file of `rocsafe scene solids` change '
        'the wind, for missions whose air.wind names a scene: docs/dispersion.md.',
    )
    found.add_argument('solids', type=Path, metavar='SOLIDS.npz', help='file of solids')
    found.add_argument(
        '--towards', required=True, nargs=2, type=float, metavar=('EAST', 'NORTH'),
        help='mean wind: velocity towards east and north, m/s',
    )  # fmt: skip
    found.add_argument(
        '--height', type=float, default=10.0, metavar='M',
        help='height above the ground of the mean wind, metres (default: 10)',
    )  # fmt: skip
    found.add_argument(
        '--roughness', type=float, default=0.03, metavar='M',
        help='roughness length of the ground, metres (default: 0.03)',
    )  # fmt: skip
    found.add_argument(
        '--stability', choices=CLASSES, default='D',
        help='Pasquill class of the stability of the air (default: D)',
    )  # fmt: skip
    found.add_argument(
        '--cell', type=float, default=SMALLEST_CELL_M, metavar='M',
        help=f'smallest cell, metres (default: {SMALLEST_CELL_M:g}); large sites have larger ones',
    )  # fmt: skip
    found.add_argument(
        '--out', type=Path, default=Path('site_wind.npz'), metavar='FILE',
        help='file to write (default: site_wind.npz)',
    )  # fmt: skip
    return found


def _pattern(arguments: argparse.Namespace) -> SitePattern:
    east, north = arguments.towards
    settings = WindSettings(
        towards_east_mps=east,
        towards_north_mps=north,
        height_m=arguments.height,
        roughness_m=arguments.roughness,
        stability=arguments.stability,
    )
    layer = settings.layer()
    if layer is None:
        raise ValueError(f'--towards {east:g} {north:g}: must be at least {LEAST_WIND_MPS:g} m/s')
    solids = read_solids(arguments.solids)
    mean = ProfileWind(
        layer=layer,
        wind=WindVector(towards_east_mps=east, towards_north_mps=north),
        reference_height_m=arguments.height,
    )
    return building_wind(site_box(solids, arguments.cell), solids, mean)


if __name__ == '__main__':
    raise SystemExit(main())

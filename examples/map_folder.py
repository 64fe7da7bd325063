# SPDX-License-Identifier: Apache-2.0
"""Make a map of a folder of drone photographs, and say how good it is.

python examples/map_folder.py PHOTOS
"""

import json
import sys
from pathlib import Path

import rasterio

from rocsafe_mapping.command_line.map_command import main as map_command


def main(folder: str) -> tuple[int, int]:
    """Map the folder; return columns and rows of the map."""
    code = map_command([folder, '--only-geotiff'])
    if code:
        sys.exit(code)
    quality = json.loads(Path(folder, 'map', 'quality.json').read_text())
    print(f'figures of the quality: {", ".join(sorted(quality))}')
    with rasterio.open(Path(folder, 'map', 'mosaic.tif')) as mosaic:
        print(f'{mosaic.width} x {mosaic.height} pixels of {mosaic.res[0]:.2f} m, {mosaic.crs}')
        return mosaic.width, mosaic.height


if __name__ == '__main__':
    main(sys.argv[1])

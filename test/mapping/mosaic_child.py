# SPDX-License-Identifier: Apache-2.0
"""Maps a store live and writes the map: a process that tests kill.

``python mosaic_child.py STORE FOLDER``
"""

import sys
from pathlib import Path

from rocsafe_mapping.live.live_map import LiveMap
from rocsafe_mapping.mosaic.mapmaker import MapOptions
from rocsafe_mapping.products.map_products import ProductOptions, write_products
from rocsafe_mapping.store.catalogue import read_store


def main() -> None:
    """Do what the mosaic node does, without ROS."""
    store, folder = map(Path, sys.argv[1:])
    sys.stdout.write('begin\n')
    sys.stdout.flush()
    growing = LiveMap(MapOptions(ground_resolution_m=0.1), folder / 'tiles', print)
    for shot in read_store(store, print):
        growing.receive(shot.record, shot.read_image)
        growing.release_tiles()
        while growing.work():
            pass
    growing.finish()
    alignment = growing.maker.align()
    write_products(
        growing.maker, alignment, ProductOptions(geotiff=folder / 'm.tif', folder=folder)
    )
    growing.close()


if __name__ == '__main__':
    main()

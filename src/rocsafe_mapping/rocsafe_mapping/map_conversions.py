# SPDX-License-Identifier: Apache-2.0
"""The map -> messages."""

from rocsafe_interfaces.msg import Mosaic
from rocsafe_mapping.live.live_map import LiveMap
from rocsafe_mapping.products.map_files import MapFiles
from rocsafe_ros.conversions import EARTH_FRAME, point_of_position


def mosaic_message(live: LiveMap, files: MapFiles) -> Mosaic:
    """Return the map as a message, without a stamp."""
    south_west, north_east = live.preview.corners()
    message = Mosaic(
        path=files.geotiff,
        is_final=files.is_final,
        images_placed=len(live),
        images_by_features=live.by_features,
        epsg_code=live.maker.epsg,
        ground_resolution_m=files.ground_resolution_m,
        south_west=point_of_position(south_west),
        north_east=point_of_position(north_east),
        stated_error_m=files.stated_error_m,
        is_georeferenced=files.is_georeferenced,
        tiles_path=files.tiles,
        quality_path=files.quality,
    )
    message.header.frame_id = EARTH_FRAME
    message.preview.format = 'png'
    message.preview.data = live.preview.png()
    return message

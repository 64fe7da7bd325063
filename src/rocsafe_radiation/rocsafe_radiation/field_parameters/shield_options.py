# SPDX-License-Identifier: Apache-2.0
"""Options of what stands between sources and detectors."""

from dataclasses import dataclass, field

from rocsafe_geo.position import GeoPosition
from rocsafe_radiation.field_parameters.field_assembly import BoxLists, places_of, shielding_of
from rocsafe_radiation.field_parameters.shielding_provider import provided_shielding
from rocsafe_radiation.field_parameters.terrain_options import TerrainOptions, lifted
from rocsafe_radiation.physics.shielding import Shielding, joined


@dataclass(frozen=True, slots=True, kw_only=True)
class ShieldOptions(TerrainOptions):
    """Boxes, as parallel lists, and a scene that somebody else knows."""

    box_materials: tuple[str, ...] = field(
        default=(),
        metadata={'doc': 'materials of the boxes that shield: iron, lead, concrete, water'},
    )
    box_latitudes_deg: tuple[float, ...] = field(
        default=(), metadata={'doc': 'WGS84 latitudes of the middles of the boxes, degrees'}
    )
    box_longitudes_deg: tuple[float, ...] = field(
        default=(), metadata={'doc': 'WGS84 longitudes of the middles of the boxes, degrees'}
    )
    box_altitudes_m: tuple[float, ...] = field(
        default=(), metadata={'doc': 'altitudes of their bottoms above the ellipsoid, metres'}
    )
    box_lengths_m: tuple[float, ...] = field(
        default=(), metadata={'doc': 'lengths of the boxes, metres'}
    )
    box_widths_m: tuple[float, ...] = field(
        default=(), metadata={'doc': 'widths of the boxes, metres'}
    )
    box_heights_m: tuple[float, ...] = field(
        default=(), metadata={'doc': 'heights of the boxes, metres'}
    )
    box_headings_deg: tuple[float, ...] = field(
        default=(),
        metadata={'doc': 'directions of their lengths, degrees clockwise from north; none: north'},
    )
    box_walls_m: tuple[float, ...] = field(
        default=(), metadata={'doc': 'thickness of their walls, metres; 0 or none: solid'}
    )
    shielding: str = field(
        default='',
        metadata={
            'doc': 'who knows a scene whose things shield, too: module:function of the file, the '
            'seed and the origin; empty: nobody'
        },
    )
    shielding_file: str = field(default='', metadata={'doc': 'the file of that scene'})
    origin_latitude_deg: float = field(
        default=0.0, metadata={'doc': 'WGS84 latitude of the mission origin, degrees'}
    )
    origin_longitude_deg: float = field(
        default=0.0, metadata={'doc': 'WGS84 longitude of the mission origin, degrees'}
    )
    origin_altitude_m: float = field(
        default=0.0,
        metadata={'doc': 'altitude of the ground there above the ellipsoid, metres', 'max': 1e4},
    )
    ground_altitude_m: float = field(
        default=0.0,
        metadata={
            'doc': 'altitude of level ground above the ellipsoid, metres; with a terrain, that '
            'above which sources and boxes are given: they are lifted to its ground',
            'max': 1e4,
        },
    )

    def shield(self, seed: int) -> Shielding | None:
        """Return what stands in the way of rays, None if nothing does.

        Raises
        ------
        ValueError: naming the box or the scene, the value and the limit.
        """
        parts: list[Shielding] = []
        boxes = shielding_of(self.box_lists())
        if boxes is not None:
            parts.append(boxes)
        if self.shielding:
            origin = GeoPosition(
                self.origin_latitude_deg, self.origin_longitude_deg, self.origin_altitude_m
            )
            parts.append(provided_shielding(self.shielding, self.shielding_file, seed, origin))
        return joined(parts)

    def on_ground(self, places: tuple[GeoPosition, ...]) -> tuple[GeoPosition, ...]:
        """Return places as high above the ground as they are above level ground.

        Raises
        ------
        ValueError: in one line, if the terrain is wrong.
        """
        return lifted(places, self.heights(), self.ground_altitude_m)

    def box_lists(self) -> BoxLists:
        """Return the boxes described."""
        return BoxLists(
            materials=self.box_materials,
            places=self.on_ground(
                places_of(
                    [f'box {index}' for index in range(len(self.box_materials))],
                    self.box_latitudes_deg,
                    self.box_longitudes_deg,
                    self.box_altitudes_m,
                )
            ),
            sizes_m=tuple(
                zip(self.box_lengths_m, self.box_widths_m, self.box_heights_m, strict=True)
            ),
            headings_deg=self.box_headings_deg,
            walls_m=self.box_walls_m,
        )

# SPDX-License-Identifier: Apache-2.0
"""Maker of a map: takes photographs in, aligns them and has them drawn."""

import dataclasses
import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from rocsafe_mapping.alignment.adjustment.height_error import height_error
from rocsafe_mapping.alignment.adjustment.least_squares import (
    residuals_px,
    stated_error_m,
    tie_heights,
)
from rocsafe_mapping.alignment.block import BY_GPS, Block
from rocsafe_mapping.alignment.initial.pair_graph import groups_of
from rocsafe_mapping.alignment.model.photo import (
    GroundFrame,
    Photo,
    ground_frame_of,
    photo_of_record,
)
from rocsafe_mapping.alignment.model.state import Lens
from rocsafe_mapping.alignment_options import AlignmentOptions
from rocsafe_mapping.drawing.grid import LOCAL_EPSG, MapGrid, utm_epsg
from rocsafe_mapping.drawing.pixel_cache import PixelCache, ReadImage
from rocsafe_mapping.drawing.placed_photo import PlacedPhoto
from rocsafe_mapping.drawing.renderer import Renderer
from rocsafe_mapping.drawing_options import DrawingOptions
from rocsafe_mapping.errors import MappingError, PlacementError
from rocsafe_mapping.mosaic.map_alignment import Alignment
from rocsafe_mapping.mosaic.one_place import distances_from_most_m
from rocsafe_mapping.mosaic.survey import (
    Survey,
    SurveyedMark,
    control_in,
    found_points,
    frame_of,
    path_in,
)
from rocsafe_mapping.photographs.shot import ShotRecord

DEFAULT_MAX_PIXELS, LEAST_PIXELS = 400_000_000, 10_000
FARTHEST_M = 100_000.0
"""A photograph farther from the first one is no part of a map in one plane."""

Notice = Callable[[str], None]


@dataclass(frozen=True, slots=True, kw_only=True)
class MapOptions:
    """What map is wanted.

    Attributes
    ----------
    ground_resolution_m
        Side of a pixel; 0: that of the photographs.
    max_pixels
        Limit of width times height; a larger map gets coarser pixels.
    """

    ground_resolution_m: float = 0.0
    max_pixels: int = DEFAULT_MAX_PIXELS
    alignment: AlignmentOptions = field(default_factory=AlignmentOptions)
    drawing: DrawingOptions = field(default_factory=DrawingOptions)

    def __post_init__(self) -> None:
        if not 0.0 <= self.ground_resolution_m < math.inf:
            raise ValueError(
                f'ground_resolution_m = {self.ground_resolution_m} must be at least 0 and finite'
            )
        if self.max_pixels < LEAST_PIXELS:
            raise ValueError(f'max_pixels = {self.max_pixels} must be at least {LEAST_PIXELS}')


@dataclass(frozen=True, slots=True, kw_only=True)
class Shot:
    """A photograph to be mapped.

    Attributes
    ----------
    name
        Of its file; unique among the photographs of a map.
    record
        Its record.
    read
        Returns its file.
    """

    name: str
    record: ShotRecord
    read: ReadImage


class Mapmaker:
    """Takes in photographs, aligns them and draws the map.

    Parameters
    ----------
    options
        What map is wanted.
    notice
        Is told, in one line each, of photographs that cannot be on the map.
    """

    def __init__(self, options: MapOptions, notice: Notice = lambda _text: None) -> None:
        self.options = options
        self._notice = notice
        self.pixels = PixelCache()
        self.block = Block(self.pixels.gray, options.alignment)
        self.frame: GroundFrame | None = None
        self.epsg = LOCAL_EPSG
        self._control: tuple[SurveyedMark, ...] = ()
        self._datum_error_m = 0.0

    def __len__(self) -> int:
        return len(self.block)

    def __contains__(self, name: str) -> bool:
        return name in self.block

    @property
    def finest_resolution_m(self) -> float:
        """Side of the ground that a pixel of the photographs shows, as they lie now."""
        block = self.block
        sizes = [
            placement.pose.centre[2] / block.photo(name).camera.fx_px
            for name, placement in block.placements().items()
        ]
        return round(float(np.median(sizes)), 4)

    def add_all(self, shots: Sequence[Shot], survey: Survey | None = None) -> None:
        """Take in photographs of one place, also those without a fix or a height.

        Photographs far away from most others are left out; `notice` is told of each.

        Raises
        ------
        MappingError
            If `survey` is of another place, or shows no photograph.
        """
        survey = survey or Survey()
        placed = [shot for shot in shots if shot.record.has_fix]
        positions = [(shot.record.latitude_deg, shot.record.longitude_deg) for shot in placed]
        far = set()
        for shot, away_m in zip(placed, distances_from_most_m(positions), strict=True):
            if away_m > 0.0:
                far.add(shot.name)
                self._notice(
                    f'not on the map: {shot.name}: its fix is {away_m / 1000.0:.0f} km from most '
                    'other photographs'
                )
        left = [shot for shot in shots if shot.name not in far]
        if not any(shot.record.has_fix for shot in left):
            self.frame, self.epsg = frame_of(survey)
        # Those with a fix first: the first of them gives the frame.
        for shot in sorted(left, key=lambda shot: not shot.record.has_fix):
            try:
                self._take(shot)
            except PlacementError as error:
                self._notice(f'not on the map: {shot.name}: {error}')
        if self.frame is not None:
            records = {shot.name: shot.record for shot in left if shot.name in self.block}
            self._control = control_in(self.frame, survey, records)
            self._datum_error_m = survey.datum_error_m
            self.block.marks = tuple(m.mark for m in self._control if not m.is_check)
            self.block.path = path_in(self.frame, survey)
            self.block.clock_offset_s = survey.clock_offset_s

    def add(self, record: ShotRecord, read: ReadImage) -> Photo:
        """Take in a photograph, placed by its fix until it is aligned.

        Raises
        ------
        PlacementError
            If its position, height or attitude is unknown, or it is far from the first one.
        """
        if not record.has_fix:
            raise PlacementError(f'{record.shot_id}: taken without a fix')
        if math.isnan(record.height_agl_m):
            raise PlacementError(f'{record.shot_id}: height_agl_m = nan is unknown')
        try:
            return self._take(Shot(name=record.shot_id, record=record, read=read))
        except PlacementError as error:
            raise PlacementError(f'{record.shot_id}: {error}') from error

    def _take(self, shot: Shot) -> Photo:
        record = shot.record
        frame = self.frame or ground_frame_of(record)
        photo = photo_of_record(record, frame, self.options.alignment.prior, shot.name)
        away_m = float(np.linalg.norm(photo.prior.centre[:2]))
        # NaN, hence no, without a fix.
        if away_m > FARTHEST_M:
            raise PlacementError(
                f'its fix is {away_m / 1000.0:.0f} km from the first photograph, more than '
                f'{FARTHEST_M / 1000.0:g} km'
            )
        if self.frame is None:
            self.epsg = utm_epsg(record.latitude_deg, record.longitude_deg)
            self.frame = frame
        self.pixels.add(photo, shot.read)
        self.block.add(photo)
        return photo

    def align(self, step: Callable[[str], None] = lambda _stage: None) -> Alignment:
        """Find where all photographs are; `step` is told the name of each finished stage.

        Raises
        ------
        PlacementError
            If heights above the ground are unknown and cannot be found.
        """
        self.drop_unreadable()
        for name in self.block.find_pairs():
            self._notice(
                f'not on the map: {name}: taken without a fix, and nothing ties it to the others'
            )
        if self.block.path is not None and math.isfinite(self.block.clock_offset_s):
            self._notice(
                f'clock of the camera: {self.block.clock_offset_s:+.1f} s to that of the track'
            )
        step('match')
        while True:
            self.block.place_all()
            self._drop_unturned()
            alignment = self.alignment()
            if not self._drop_uncertain(alignment):
                break
        step('adjust')
        return alignment

    def _drop_unturned(self) -> None:
        """Leave out photographs that nothing ties to the others nor tells which way they look."""
        if not self.block.state.poses:
            return
        for name, placement in self.block.placements().items():
            if placement.placed_by == BY_GPS and not self.block.photo(name).has_yaw:
                self.block.remove(name)
                self._notice(
                    f'not on the map: {name}: nothing tells its heading, and nothing ties it to '
                    'the others'
                )

    def _drop_uncertain(self, alignment: Alignment) -> bool:
        """Leave out tied photographs that may be off by more than half of what they show.

        A few that are tied to each other alone, by fixes that are too near to each other, have
        neither scale nor north. Where most are so, the whole map is, and says it. Returns whether
        there were any.
        """
        shown_m = {}
        for name, placement in alignment.placements.items():
            camera = self.block.photo(name).camera
            slope = math.hypot(camera.width_px, camera.height_px) / camera.fx_px
            shown_m[name] = float(placement.pose.centre[2]) * slope
        lost = {n: e for n, e in alignment.errors_m.items() if e > 0.5 * shown_m[n]}
        if 2 * len(lost) > len(alignment.errors_m):
            return False
        for name, error_m in lost.items():
            self.block.remove(name)
            self._notice(
                f'not on the map: {name}: it may be off by {error_m:.0f} m, more than half of '
                f'the {shown_m[name]:.0f} m that it shows'
            )
        return bool(lost)

    def drop_unreadable(self) -> None:
        """Leave out photographs whose pixels cannot be had, and say so."""
        for name in self.block.pair_table.without_features():
            try:
                self.block.pair_table.extract(name)
            except MappingError as error:
                self._notice(f'not on the map: {error}')
                self.block.remove(name)

    def alignment(self) -> Alignment:
        """Return where all photographs are now."""
        block = self.block
        state, photos, pairs = block.state, block.photos, block.used_pairs
        options = self.options.alignment
        most = options.adjustment.most_ties
        heights = tie_heights(photos, pairs, state, most)
        errors = stated_error_m(photos, pairs, state, options.adjustment) if state.poses else {}
        return Alignment(
            heights=heights,
            photos=photos,
            placements=block.placements(),
            heights_error=height_error(state.surface, heights, options),
            lags_s=block.lags_s,
            groups=tuple(map(len, groups_of(pairs))),
            control=found_points(self._control, photos, state),
            is_local=block.is_local,
            errors_m={
                n: math.hypot(error_m, self._datum_error_m) for n, error_m in errors.items()
            },
            held_out_px=residuals_px(photos, pairs, state, most, held_out=True),
        )

    def placed_photos(self, names: Collection[str] | None = None) -> dict[str, PlacedPhoto]:
        """Return the photographs, or some of them, as they lie now."""
        state = self.block.state
        return {
            name: PlacedPhoto(
                photo=self.block.photo(name),
                pose=placement.pose,
                lens=state.lenses.get(self.block.photo(name).lens, Lens()),
                surface=state.surface,
            )
            for name, placement in self.block.placements(names).items()
        }

    def renderer(self, *, with_relief: bool = False) -> Renderer:
        """Return what draws the map as the photographs lie now.

        `with_relief` also finds heights of what stands on the ground, which takes time.

        Raises
        ------
        PlacementError
            If there is no photograph.
        """
        placed_photos = self.placed_photos()
        tied = self.block.state.poses if with_relief else ()
        return Renderer(
            placed_photos, self.pixels, self.grid(placed_photos), self.options.drawing, tied
        )

    def grid(self, placed_photos: Mapping[str, PlacedPhoto]) -> MapGrid:
        """Return the map's grid, its pixels as fine as its limits allow.

        Raises
        ------
        PlacementError
            If there is no photograph.
        """
        if self.frame is None or not placed_photos:
            raise PlacementError('no photograph is placed yet')
        wished = self.options.ground_resolution_m
        if wished == 0.0:
            wished = self.finest_resolution_m
        corners = np.concatenate([placed.corners_m for placed in placed_photos.values()])
        side_m = float(np.ptp(corners, axis=0).max())
        if wished > side_m:
            raise PlacementError(
                f'ground_resolution_m = {wished:g} must be at most {side_m:.3g}, the '
                'side of the map'
            )
        grid = MapGrid(epsg=self.epsg, resolution_m=wished, frame=self.frame)
        while True:
            window = grid.window_of(corners)
            if window.width * window.height <= self.options.max_pixels:
                break
            grid = dataclasses.replace(grid, resolution_m=2.0 * grid.resolution_m)
        if grid.resolution_m > wished:
            self._notice(
                f'the map would exceed {self.options.max_pixels} pixels: its pixels are now '
                f'{grid.resolution_m:g} m wide, not {wished:g} m'
            )
        return grid

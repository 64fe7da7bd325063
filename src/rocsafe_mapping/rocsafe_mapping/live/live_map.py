# SPDX-License-Identifier: Apache-2.0
"""The map while photographs come in: each is placed by its fix, then by its ties.

Work is done in small pieces, the most urgent first, so that a new photograph is shown soon: adopt
a finished adjustment, tie photographs, draw released tiles, start an adjustment.
"""

from collections import deque
from collections.abc import Callable, Collection
from concurrent.futures import Future, ThreadPoolExecutor, wait
from pathlib import Path

from rocsafe_geo.arrays import FloatArray
from rocsafe_mapping.alignment.block import BY_FEATURES
from rocsafe_mapping.alignment.steps import Solution
from rocsafe_mapping.drawing.pixel_cache import ReadImage
from rocsafe_mapping.errors import MappingError
from rocsafe_mapping.live.preview import Preview
from rocsafe_mapping.live.web_tiles import WebTiles
from rocsafe_mapping.mosaic.mapmaker import Mapmaker, MapOptions, Notice
from rocsafe_mapping.photographs.shot import ShotRecord

# All photographs are adjusted together when their number has grown by this factor.
GROWTH = 1.5
FEWEST = 6
# A photograph is drawn again when a corner has moved this far, pixels of it or of the map.
LEAST_MOVE_PX = 0.5
# Between two rounds of drawing the tiles that changed.
TILES_S = 4.0


class LiveMap:
    """A map that grows.

    Parameters
    ----------
    options
        What map is wanted.
    tiles_directory
        Where its tiles for web maps are kept up to date.
    notice
        Is told, in one line each, of photographs that cannot be on the map.
    """

    def __init__(self, options: MapOptions, tiles_directory: Path, notice: Notice) -> None:
        self.maker = Mapmaker(options, notice)
        self.preview = Preview(self.maker)
        self._tiles = WebTiles(self.maker, tiles_directory, options.ground_resolution_m)
        self._resolution_m = options.ground_resolution_m
        self._notice = notice
        self._to_tie: deque[str] = deque()
        self._drawn_m: dict[str, FloatArray] = {}
        self._adjusted_count = FEWEST / GROWTH
        self._thread = ThreadPoolExecutor(1, thread_name_prefix='adjustment')
        self._pending: Future[Solution] | None = None

    def __contains__(self, name: str) -> bool:
        return name in self.maker

    def __len__(self) -> int:
        return len(self.maker)

    @property
    def by_features(self) -> int:
        """How many photographs lie where they fit."""
        placed = self.maker.block.placements().values()
        return sum(placement.placed_by == BY_FEATURES for placement in placed)

    def receive(self, record: ShotRecord, read: ReadImage) -> None:
        """Show a photograph where its fix says.

        Raises
        ------
        PlacementError
            If it can never be placed.
        StoreError
            If it cannot be read now.
        """
        read()
        photo = self.maker.add(record, read)
        try:
            self.maker.pixels.colour(photo.name)
        except MappingError:
            self.maker.block.remove(photo.name)
            raise
        self._to_tie.append(photo.name)
        self._mark([photo.name])

    def work(self) -> bool:
        """Do the most urgent piece of work; return whether there was any."""
        pieces: tuple[Callable[[], bool], ...] = (
            self._adopt,
            self._tie,
            self._tiles.draw_next,
            self._solve,
        )
        return any(piece() for piece in pieces)

    @property
    def is_busy(self) -> bool:
        """Whether a photograph waits to be tied or an adjustment is under way."""
        return bool(self._to_tie) or self._pending is not None

    def wait(self, at_most_s: float) -> None:
        """Wait for the adjustment that is under way, if there is one."""
        if self._pending is not None:
            wait([self._pending], at_most_s)

    def finish(self) -> None:
        """Wait for the adjustment that is under way, and forget it."""
        if self._pending is not None:
            self._pending.result()
            self._pending = None
        self._to_tie.clear()

    def close(self) -> None:
        """End the thread."""
        self._thread.shutdown(wait=True, cancel_futures=True)

    def mark_all(self) -> None:
        """Note that any photograph may have moved."""
        self._mark(tuple(self.maker.block.photos))

    @property
    def has_stale_tiles(self) -> bool:
        """Whether tiles are out of date and not released."""
        return self._tiles.is_stale

    def release_tiles(self) -> None:
        """Let `work` draw the tiles that are out of date now."""
        self._tiles.release()

    def draw_tiles(self) -> None:
        """Draw all tiles that are out of date, now: nobody may be there to do it later."""
        self._tiles.release()
        try:
            while self._tiles.draw_next():
                pass
        except MappingError as error:
            self._notice(f'the tiles are not complete: {error}')

    def _tie(self) -> bool:
        if not self._to_tie:
            return False
        name = self._to_tie.popleft()
        block = self.maker.block
        try:
            if block.pair_table.match_new(name):
                self._mark(block.place(name))
        except MappingError as error:
            self._notice(f'{name} stays where its fix says: {error}')
        return True

    def _solve(self) -> bool:
        """Begin to adjust all photographs when there are many new ones."""
        count = len(self.maker.block.state.poses)
        if self._pending is not None or count < GROWTH * self._adjusted_count:
            return False
        self._adjusted_count = float(count)
        self._pending = self._thread.submit(self.maker.block.global_solution())
        return True

    def _adopt(self) -> bool:
        if self._pending is None or not self._pending.done():
            return False
        solution, self._pending = self._pending.result(), None
        self.maker.block.adopt(solution)
        self.mark_all()
        return True

    def _mark(self, names: Collection[str]) -> None:
        """Note which photographs moved so far that they must be drawn again."""
        for name, placed in self.maker.placed_photos(names).items():
            before = self._drawn_m.get(name)
            pixel_m = max(placed.photo.ground_resolution_m, self._resolution_m)
            least_m = LEAST_MOVE_PX * pixel_m
            if before is not None and abs(before - placed.corners_m).max() < least_m:
                continue
            self.preview.show(placed)
            self._tiles.move(placed, before)
            self._drawn_m[name] = placed.corners_m

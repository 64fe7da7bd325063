# SPDX-License-Identifier: Apache-2.0
"""The growing map in a thread of its own: it is refined, drawn and written beside the node."""

import dataclasses
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

from rocsafe_geo.regions.area import SurveyArea
from rocsafe_mapping.errors import MappingError, PlacementError, StoreError
from rocsafe_mapping.live.live_map import LiveMap
from rocsafe_mapping.mosaic.mapmaker import MapOptions, Notice
from rocsafe_mapping.options import MosaicOptions
from rocsafe_mapping.products.map_files import (
    TILES,
    MapFiles,
    files_after,
    files_before,
    product_options_of,
)
from rocsafe_mapping.products.map_products import write_products
from rocsafe_mapping.store.catalogue import read_shot, read_store

# Between two looks at an adjustment that is under way.
PAUSE_S = 0.01
Show = Callable[[LiveMap, MapFiles], None]
Answer = Callable[[bool, str], None]


class MapWorker:
    """Does all work on a growing map, one task after the other, in one thread.

    The methods return at once; what they start is done in the order in which it was asked for.
    Refinement goes on between the tasks while there is something to refine.

    Parameters
    ----------
    options
        Where the store is, and what map is wanted.
    show
        Is called in the thread with the map and its files when the map shall be published.
    notice
        Is told, in one line each, what cannot be on the map or cannot be written.
    """

    def __init__(self, options: MosaicOptions, show: Show, notice: Notice) -> None:
        self._options = options
        self._show = show
        self._notice = notice
        self._store = Path(options.store_directory)
        self._files = files_before(options)
        self._live = LiveMap(
            MapOptions(
                ground_resolution_m=options.ground_resolution_m, max_pixels=options.max_pixels
            ),
            options.products / TILES,
            notice,
        )
        self._refused: set[str] = set()
        self._is_refining = False
        self._failure: BaseException | None = None
        self._thread = ThreadPoolExecutor(1, thread_name_prefix='map')

    def check(self) -> None:
        """Raise the exception that ended a task, if there is one."""
        if self._failure is not None:
            raise self._failure

    def receive(self, shot_id: str) -> None:
        """Show a stored photograph, then find where it fits."""
        self._start(self._receive, shot_id)

    def receive_stored(self) -> None:
        """Receive all photographs of the store: after a restart, or where a receipt was lost."""
        self._start(self._receive_stored)

    def show_changes(self) -> None:
        """Have the map shown if its preview changed."""
        self._start(self._show_changes)

    def update_tiles(self) -> None:
        """Draw the tiles that are out of date."""
        self._start(self._update_tiles)

    def save(self, region: SurveyArea | None, answer: Answer) -> None:
        """Place all that is stored and write the map, unless that is done.

        Parameters
        ----------
        region
            That was to be covered, if it is known.
        answer
            Is called in the thread when the map is written, with what was written in one line, or
            when it cannot be, with the reason.
        """
        self._start(self._save, region, answer)

    def close(self) -> None:
        """End the thread after the task that is under way."""
        self._thread.shutdown(wait=True, cancel_futures=True)
        self._live.close()

    def _start(self, task: Callable[..., None], *arguments: object) -> None:
        self._thread.submit(task, *arguments).add_done_callback(self._note_failure)

    def _note_failure(self, ended: Future[None]) -> None:
        if not ended.cancelled() and ended.exception() is not None:
            self._failure = ended.exception()

    def _receive(self, shot_id: str) -> None:
        if shot_id in self._live or shot_id in self._refused:
            return
        try:
            shot = read_shot(self._store, shot_id)
            self._live.receive(shot.record, shot.read_image)
        except PlacementError as error:
            self._refused.add(shot_id)
            self._notice(f'not on the map: {error}')
        except StoreError as error:
            self._notice(str(error))
        else:
            self._files = dataclasses.replace(self._files, is_final=False)
            self._refine_later()

    def _receive_stored(self) -> None:
        try:
            shots = read_store(self._store, self._notice)
        except StoreError as error:
            self._notice(str(error))
            return
        for shot in shots:
            self._receive(shot.record.shot_id)

    def _refine_later(self) -> None:
        """Refine the map when the tasks that were asked for before are done."""
        if not self._is_refining:
            self._is_refining = True
            self._again()

    def _again(self) -> None:
        try:
            self._start(self._refine)
        except RuntimeError:
            # The thread is being ended.
            self._is_refining = False

    def _refine(self) -> None:
        """Do one piece of work on the map, and ask for the next one if there may be more."""
        try:
            has_worked = self._live.work()
        except MappingError as error:
            self._notice(str(error))
            has_worked = False
        if has_worked or self._live.is_busy:
            if not has_worked:
                self._live.wait(PAUSE_S)
            self._again()
        else:
            self._is_refining = False

    def _show_changes(self) -> None:
        if self._live.preview.is_due:
            self._show(self._live, self._files)

    def _update_tiles(self) -> None:
        if self._live.has_stale_tiles:
            self._live.release_tiles()
            self._refine_later()

    def _save(self, region: SurveyArea | None, answer: Answer) -> None:
        try:
            message = self._written(region)
        except MappingError as error:
            answer(False, str(error))
        else:
            answer(True, message)

    def _written(self, region: SurveyArea | None) -> str:
        """Write the map; return what was written, in one line."""
        self._receive_stored()
        # A client may ask again while the first request is carried out.
        if not (self._files.is_final and Path(self._files.geotiff).exists()):
            self._live.finish()
            alignment = self._live.maker.align()
            wanted = product_options_of(self._options, self._live.maker, region)
            quality = write_products(self._live.maker, alignment, wanted)
            self._live.mark_all()
            self._files = files_after(self._files, self._options, quality)
            self._show(self._live, self._files)
            # A mission ends its nodes as soon as the map is written.
            self._live.draw_tiles()
        message = f'{len(self._live)} photographs in {self._files.geotiff}'
        if self._refused:
            message += f', {len(self._refused)} could not be placed'
        return message

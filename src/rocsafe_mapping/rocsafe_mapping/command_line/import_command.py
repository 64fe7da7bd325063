# SPDX-License-Identifier: Apache-2.0
"""`import`: anyone's drone photographs into an image store."""

import argparse
import dataclasses
import sys
from collections.abc import Sequence
from pathlib import Path

from rocsafe_mapping.command_line.notes import note
from rocsafe_mapping.errors import MappingError
from rocsafe_mapping.photographs.shot import ShotRecord
from rocsafe_mapping.store.catalogue import read_store
from rocsafe_mapping.store.listings import write_listings
from rocsafe_mapping.store.photograph_files import photographs_of
from rocsafe_mapping.store.store import ImageStore, Status
from rocsafe_mapping.store.store_index import write_index

EXIT_OK, EXIT_SOME_REFUSED, EXIT_REFUSED = 0, 1, 2


def main(arguments: Sequence[str] | None = None) -> int:
    """Import, print what became of the photographs, and return the exit code."""
    options = _parser().parse_args(arguments)
    try:
        counts = import_folder(options.folder, options.store)
    except (MappingError, OSError) as error:
        note(f'error: {error}')
        return EXIT_REFUSED
    sys.stdout.write(
        f'{counts[Status.STORED]} stored, {counts[Status.DUPLICATE]} there already, '
        f'{counts[Status.REJECTED]} refused; {options.store}\n'
    )
    return EXIT_SOME_REFUSED if counts[Status.REJECTED] else EXIT_OK


def import_folder(folder: Path, directory: Path) -> dict[Status, int]:
    """Take the photographs of `folder` into the store `directory`; return how many became what.

    Their own tags stay; a photograph that is there already, whatever its name, is not taken again.

    Raises
    ------
    MappingError
        If the folder cannot be read or the store cannot be written.
    """
    counts = dict.fromkeys(Status, 0)

    def refuse(text: str) -> None:
        counts[Status.REJECTED] += 1
        note(text)

    store = ImageStore(directory, refuse)
    try:
        numbers = _Numbers([shot.record for shot in read_store(directory, refuse)])
        for shot in photographs_of(folder, refuse):
            record = numbers.given(shot.record)
            if record is None:
                counts[Status.DUPLICATE] += 1
                continue
            answer = store.put(record, shot.read_image(), is_tagged=True)
            counts[answer.status] += 1
            if answer.status is Status.REJECTED:
                note(f'{shot.path}: {answer.reason}')
    finally:
        store.close()
    shots = read_store(directory, refuse)
    write_listings(directory, shots)
    write_index(directory, shots)
    return counts


class _Numbers:
    """Gives photographs names that are free in a store.

    Parameters
    ----------
    records
        Of the photographs that are there.
    """

    def __init__(self, records: Sequence[ShotRecord]) -> None:
        self._known = {record.sha256 for record in records}
        self._next: dict[str, int] = {}
        for record in records:
            self._use(record)

    def given(self, record: ShotRecord) -> ShotRecord | None:
        """Return `record` with a name that is free, None if its image is there already."""
        if record.sha256 in self._known:
            return None
        number = self._next.get(record.vehicle, 0)
        named = dataclasses.replace(
            record,
            sequence=number,
            viewpoint_id=number,
            shot_id=f'{record.vehicle}-{number:05d}',
        )
        self._known.add(record.sha256)
        self._use(named)
        return named

    def _use(self, record: ShotRecord) -> None:
        self._next[record.vehicle] = max(self._next.get(record.vehicle, 0), record.sequence + 1)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='rocsafe import',
        description='Take drone photographs with Exif into an image store.',
    )
    parser.add_argument('folder', type=Path, metavar='FOLDER', help='folder of photographs')
    parser.add_argument('store', type=Path, metavar='STORE', help='image store; made if missing')
    return parser


if __name__ == '__main__':
    sys.exit(main())

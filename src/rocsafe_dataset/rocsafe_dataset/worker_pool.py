# SPDX-License-Identifier: Apache-2.0
"""Distribution of the images to processes, each with an engine of its own."""

import json
import multiprocessing
import os
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import asdict
from hashlib import sha256
from pathlib import Path

from rocsafe_dataset.errors import DatasetError
from rocsafe_dataset.folder.files import DatasetFolder
from rocsafe_geo.storage.durable import write_whole
from rocsafe_scene.scene.description import SceneDescription

Task = tuple[int, tuple[int, ...]]

# Images of one task: few, so that progress is visible and all workers end at about the same time.
_TASK_SIZE = 10
# Variable for the threads of the software renderer: each worker gets its share of the cores.
_RENDER_THREADS = 'LP_NUM_THREADS'


def claim_folder(folder: DatasetFolder, description: SceneDescription) -> None:
    """Create the folder of a data set, or check that it holds the same data set.

    Raises
    ------
    DatasetError
        If it holds another data set or other files, or cannot be created.
    """
    digest = sha256(description.model_dump_json().encode()).hexdigest()
    content = {
        'options': asdict(folder.options), 'scene': description.name, 'scene_sha256': digest,
    }  # fmt: skip
    wanted = json.loads(json.dumps(content))
    path = folder.path / 'dataset.json'
    try:
        folder.path.mkdir(parents=True, exist_ok=True)
        if path.exists():
            _require_same(json.loads(path.read_bytes()), wanted, folder.path)
        elif any(folder.path.iterdir()):
            raise DatasetError(f'--out = {folder.path}: is not empty and holds no data set')
        write_whole(path, json.dumps(content, indent=1).encode())
    except OSError as error:
        raise DatasetError(f'--out = {folder.path}: {error.strerror}') from error
    except ValueError as error:
        raise DatasetError(f'{path}: is damaged: {error}') from error


def _require_same(found: dict[str, object], wanted: dict[str, object], path: Path) -> None:
    for key, value in wanted.items():
        if found.get(key) != value:
            raise DatasetError(
                f'--out = {path}: holds a data set with other {key.split("_", maxsplit=1)[0]}; '
                'choose another folder'
            )


def open_tasks(folder: DatasetFolder) -> list[Task]:
    """Return the open tasks: arrangement and numbers of images."""
    options = folder.options
    tasks = []
    for arrangement in range(options.arrangements):
        start = arrangement * options.per_arrangement
        numbers = range(start, min(start + options.per_arrangement, options.count))
        left = [number for number in numbers if not folder.record(number).exists()]
        for first in range(0, len(left), _TASK_SIZE):
            tasks.append((arrangement, tuple(left[first : first + _TASK_SIZE])))
    return tasks


def run_tasks(
    tasks: Sequence[Task],
    folder: DatasetFolder,
    description: SceneDescription,
    cache: Path,
    workers: int,
) -> Iterator[int]:
    """Render all images; yield the number of images of each finished task.

    Raises
    ------
    SceneError, EngineError, DatasetError
        One line.
    """
    count = max(1, min(workers, len(tasks)))
    os.environ.setdefault(_RENDER_THREADS, str(max(1, (os.cpu_count() or 1) // count)))
    # Spawned, not forked: a fork of a process in which the engine runs hangs.
    context = multiprocessing.get_context('spawn')
    arguments = (description, folder, cache)
    with ProcessPoolExecutor(count, context, _open, arguments) as pool:
        try:
            yield from _finished(pool, tasks)
        except BrokenProcessPool as error:
            raise DatasetError(
                'a worker ended unexpectedly (memory?); run the same command again to go on'
            ) from error
        finally:
            pool.shutdown(cancel_futures=True)


def _finished(pool: ProcessPoolExecutor, tasks: Sequence[Task]) -> Iterator[int]:
    waiting: set[Future[int]] = {pool.submit(_work, task) for task in tasks}
    while waiting:
        done, waiting = wait(waiting, return_when=FIRST_COMPLETED)
        for future in done:
            yield future.result()


class _Worker:
    """State of a worker process; the first task makes the camera, and raises its errors."""

    arguments: tuple[SceneDescription, DatasetFolder, Path]
    camera: object = None


def _open(description: SceneDescription, folder: DatasetFolder, cache: Path) -> None:
    _Worker.arguments = (description, folder, cache)


def _work(task: Task) -> int:
    from rocsafe_dataset.dataset_camera import DatasetCamera, open_dataset_camera

    if not isinstance(_Worker.camera, DatasetCamera):
        _Worker.camera = open_dataset_camera(*_Worker.arguments)
    arrangement, numbers = task
    return sum(1 for _ in _Worker.camera.photograph(arrangement, numbers))

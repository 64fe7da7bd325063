# SPDX-License-Identifier: Apache-2.0
"""The files about a whole data set: COCO annotations, YOLO's list, the data card."""

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rocsafe_dataset.errors import DatasetError
from rocsafe_dataset.folder.data_card import data_card
from rocsafe_dataset.folder.files import DatasetFolder
from rocsafe_dataset.options import SPLITS
from rocsafe_geo.storage.durable import write_whole
from rocsafe_scene.mesh.classes import CLASSES

Record = Mapping[str, Any]


def finish(folder: DatasetFolder, scene: str) -> Counter[str]:
    """Write the files that need all images; return the number of instances by class.

    Raises
    ------
    DatasetError
        If a record is missing or damaged, or a file cannot be written.
    """
    records = [_read(folder.record(number)) for number in range(folder.options.count)]
    names = [label.name for label in CLASSES.values()]
    counts = Counter(
        names[annotation['category']] for record in records for annotation in record['annotations']
    )
    try:
        (folder.path / 'annotations').mkdir(exist_ok=True)
        for split in SPLITS:
            chosen = [record for record in records if record['split'] == split]
            content = json.dumps(coco(chosen, folder.options.size_px, scene)).encode()
            write_whole(folder.path / 'annotations' / f'instances_{split}.json', content)
        write_whole(folder.path / 'data.yaml', _data_yaml().encode())
        write_whole(
            folder.path / 'README.md', data_card(records, counts, folder.options, scene).encode()
        )
    except OSError as error:
        raise DatasetError(f'{error.filename}: {error.strerror}') from error
    return counts


def _read(path: Path) -> Record:
    try:
        content: Record = json.loads(path.read_bytes())
    except (OSError, ValueError) as error:
        raise DatasetError(f'{path}: is missing or damaged; run the command again') from error
    return content


def coco(records: Sequence[Record], size_px: tuple[int, int], scene: str) -> dict[str, Any]:
    """Return the content of COCO's instances file for some images."""
    width, height = size_px
    annotations = [
        {'image_id': record['number'], **annotation}
        for record in records
        for annotation in record['annotations']
    ]
    return {
        'info': {'description': f'ROCSAFE scene {scene}', 'version': '1.0'},
        'licenses': [{'id': 1, 'name': 'Apache-2.0', 'url': ''}],
        'categories': [
            {'id': label.number, 'name': label.name, 'supercategory': 'scene'}
            for label in CLASSES.values()
        ],
        'images': [
            {
                'id': record['number'], 'width': width, 'height': height, 'license': 1,
                'file_name': record['file'].split('/')[-1],
            }
            for record in records
        ],
        'annotations': [
            {
                'id': index + 1,
                'image_id': annotation['image_id'],
                'category_id': annotation['category'],
                'iscrowd': 0,
                'area': annotation['area'],
                'bbox': list(annotation['box']),
                'segmentation': {'size': [height, width], 'counts': annotation['runs']},
                'attributes': {
                    'name': annotation['name'], 'instance': annotation['number'],
                    'visibility': annotation['visibility'], 'truncated': annotation['is_cut'],
                },
            }
            for index, annotation in enumerate(annotations)
        ],
    }  # fmt: skip


def _data_yaml() -> str:
    """Return the file with which YOLO's training starts; `path` is its own folder."""
    rows = [f'  {label.number}: {label.name}' for label in CLASSES.values()]
    splits = [f'{split}: images/{split}' for split in SPLITS]
    return '\n'.join(['path: .', *splits, f'nc: {len(rows)}', 'names:', *rows, ''])

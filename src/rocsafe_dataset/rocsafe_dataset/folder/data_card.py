# SPDX-License-Identifier: Apache-2.0
"""The data card: content, making and limits of a data set."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from rocsafe_dataset.options import SPLITS, DatasetOptions
from rocsafe_scene.mesh.classes import class_number

_TEXT = """# Data card: {scene}

{count} pictures of {width} x {height} px of the made-up scene `{scene}`, drawn by a game engine
({renderer}). No person, place or event is real.

## Made with

`rocsafe dataset`, seed {seed}. The same scene, options and version give the same pictures on the
same machine. Every {per_arrangement} pictures share one placement of people, vehicles, drums,
debris and evidence items, one weather (of {weathers}) and one sun (of a year of days around that
of the scene, never lower than 9 degrees). Cameras fly {low:g} to {high:g} m above the ground;
{nadir:.0%} look straight down (within 6 degrees), the others 25 to 75 degrees below the horizon.

## Splits by place

The ground is cut into 4 x 4 blocks, each given to one split, so that nothing stands in two.
Pictures are aimed at the blocks of their split. Oblique views can see blocks of others: on average
{foreign:.1%} of the ground within 120 m, {worst:.0%} at most (`foreign_share` in `records/`).

| split | pictures | instances |
|---|---|---|
{splits}

## Files

| path | holds |
|---|---|
| `images/SPLIT/*.{suffix}` | pictures, with position, attitude and lens as Exif and XMP |
| `annotations/instances_SPLIT.json` | COCO: boxes, masks as run lengths, visibility |
| `labels/SPLIT/*.txt`, `data.yaml` | YOLO: one polygon an instance (parts joined, holes lost) |
| `masks/SPLIT/*.png` | instance of each pixel, 16 bit; 0 sky, 1 ground |
| `semantic/SPLIT/*.png` | class of each pixel, 8 bit, numbers as in `data.yaml` |
| `depth/SPLIT/*.tiff` | distance along the view, metres, float; 0 where the sky is |
| `records/*.json` | pose, camera matrix, light and annotations of each picture |

Boxes and masks cover what is seen. `visibility` is the share of an instance's pixels in the
picture that no other instance hides. Instances below {least} pixels are in the masks, but not
annotated.

## Instances

| class | instances | median pixels | median visibility |
|---|---|---|---|
{classes}

## Not good for

Learning what real cameras do: no noise, blur or lens errors are in these pictures. Shapes repeat:
people, vehicles and trees come from a few generators. Leaves are coarser than real ones.
Ground classes are those of the painted map, to 16 cm.

Licence: Apache-2.0, as the software that made them.
"""


def data_card(
    records: Sequence[Mapping[str, Any]],
    counts: Counter[str],
    options: DatasetOptions,
    scene: str,
) -> str:
    """Return the text of the data card."""
    foreign = [record['foreign_share'] for record in records]
    return _TEXT.format(
        scene=scene,
        count=options.count,
        width=options.size_px[0],
        height=options.size_px[1],
        renderer=records[0]['renderer'],
        seed=options.seed,
        per_arrangement=options.per_arrangement,
        weathers=', '.join(options.weathers),
        low=options.height_m[0],
        high=options.height_m[1],
        nadir=options.nadir_share,
        foreign=float(np.mean(foreign)),
        worst=max(foreign),
        splits='\n'.join(_split_row(split, records) for split in SPLITS),
        suffix=options.image_format,
        least=options.least_pixels,
        classes='\n'.join(_class_rows(records, counts)),
    )


def _split_row(split: str, records: Sequence[Mapping[str, Any]]) -> str:
    chosen = [record for record in records if record['split'] == split]
    instances = sum(len(record['annotations']) for record in chosen)
    return f'| {split} | {len(chosen)} | {instances} |'


def _class_rows(records: Sequence[Mapping[str, Any]], counts: Counter[str]) -> list[str]:
    found: dict[int, list[tuple[int, float]]] = {}
    for record in records:
        for annotation in record['annotations']:
            values = annotation['area'], annotation['visibility']
            found.setdefault(annotation['category'], []).append(values)
    rows = []
    for name, count in counts.most_common():
        area, visibility = np.median(found[class_number(name)], axis=0).tolist()
        rows.append(f'| {name} | {count} | {area:.0f} | {visibility:.2f} |')
    return rows

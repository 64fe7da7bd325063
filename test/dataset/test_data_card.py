# SPDX-License-Identifier: Apache-2.0
"""The data card states the figures of the records."""

from collections import Counter

from rocsafe_dataset.folder.data_card import data_card
from rocsafe_dataset.options import DatasetOptions
from rocsafe_scene.mesh.classes import class_number

CAR, PERSON = class_number('car'), class_number('person')


def record(split, foreign, *instances):
    """Return a record with instances (category, area, visibility)."""
    rows = [{'category': c, 'area': a, 'visibility': v} for c, a, v in instances]
    return {
        'split': split,
        'foreign_share': foreign,
        'renderer': 'llvmpipe',
        'annotations': rows,
    }


def test_card_counts_pictures_instances_and_medians():
    """By split and by class; the commonest class first."""
    records = [
        record('train', 0.1, (CAR, 100, 1.0), (CAR, 300, 0.5), (PERSON, 40, 0.9)),
        record('train', 0.3),
        record('val', 0.2, (CAR, 500, 0.75)),
    ]
    card = data_card(records, Counter(car=3, person=1), DatasetOptions(count=3), 'derailment')
    assert '# Data card: derailment' in card
    assert '| train | 2 | 3 |' in card
    assert '| val | 1 | 1 |' in card
    assert card.index('| car | 3 | 300 | 0.75 |') < card.index('| person | 1 | 40 | 0.90 |')
    assert '20.0% of the ground' in card
    assert '30% at most' in card
    assert '{' not in card

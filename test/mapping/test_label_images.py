# SPDX-License-Identifier: Apache-2.0
"""Label images find their photographs, and their numbers become classes."""

import json

import cv2
import numpy as np
import pytest

from rocsafe_mapping.errors import StoreError
from rocsafe_mapping.photographs.label_images import (
    LABELS,
    MOST_WAITING,
    TABLE,
    LabelImages,
    LabelKeeper,
)

NUMBERS = np.array([[1, 300], [65535, 2]], np.uint16)
ROWS = [
    {'number': 1, 'name': 'ground', 'class': 'grass', 'colour': [86, 152, 60]},
    {'number': 2, 'name': 'left tree', 'class': 'tree', 'colour': [24, 110, 36]},
    {'number': 300, 'name': 'right tree', 'class': 'tree', 'colour': [24, 110, 36]},
]


@pytest.fixture
def keeper(tmp_path):
    """A keeper of an empty store."""
    return LabelKeeper(tmp_path)


def kept(folder):
    """Return the names of the label images."""
    return sorted(path.name for path in (folder / LABELS).glob('*.png'))


@pytest.mark.parametrize('is_first', [True, False])
def test_labels_are_kept_with_their_photograph(keeper, tmp_path, is_first):
    """Whichever comes first."""
    steps = [
        lambda: keeper.add_image('rav1', 5, NUMBERS),
        lambda: keeper.add_shot('rav1', 5, 'rav1-00000'),
    ]
    for step in steps if is_first else reversed(steps):
        step()
    assert kept(tmp_path) == ['rav1-00000.png']
    picture = cv2.imread(str(tmp_path / LABELS / 'rav1-00000.png'), cv2.IMREAD_UNCHANGED)
    assert np.array_equal(picture, NUMBERS)


def test_labels_of_other_moments_and_vehicles_are_not(keeper, tmp_path):
    """A stream that somebody looks at has labels, too."""
    keeper.add_image('rav1', 4, NUMBERS)
    keeper.add_image('rav2', 5, NUMBERS)
    keeper.add_shot('rav1', 5, 'rav1-00000')
    assert kept(tmp_path) == []


def test_few_wait_for_each_other(keeper, tmp_path):
    """Memory is bounded: the oldest are given up."""
    for time_ns in range(MOST_WAITING + 1):
        keeper.add_image('rav1', time_ns, NUMBERS)
    for time_ns in (0, 1):
        keeper.add_shot('rav1', time_ns, f'rav1-0000{time_ns}')
    assert kept(tmp_path) == ['rav1-00001.png']


def test_numbers_become_classes(keeper, tmp_path):
    """Things of one class are one value; a number that no table has is unknown."""
    keeper.add_table(json.dumps(ROWS[:2]))
    keeper.add_table(json.dumps(ROWS))
    keeper.add_image('rav1', 5, NUMBERS)
    keeper.add_shot('rav1', 5, 'rav1-00000')
    images = LabelImages(tmp_path / LABELS)
    assert [(label.value, label.name) for label in images.classes] == [(1, 'grass'), (2, 'tree')]
    assert images.classes[1].colour == (24, 110, 36)
    assert images.of('rav1-00000').tolist() == [[1, 2], [0, 2]]
    assert images.of('rav1-00001') is None


@pytest.mark.parametrize('text', ['', '{}1', '[1]', '[{"number": "x"}]', '[{"class": "tree"}]'])
def test_a_table_that_is_none_is_refused(keeper, text):
    """One line instead of a traceback."""
    with pytest.raises(StoreError, match='label table is not understood'):
        keeper.add_table(text)


def test_a_damaged_table_is_refused(tmp_path):
    """The file may have been edited."""
    (tmp_path / TABLE).write_text('[{"number": 1}]')
    with pytest.raises(StoreError, match=r'table\.json is not understood'):
        LabelImages(tmp_path)


def test_16_bit_numbers_need_a_table(tmp_path):
    """Nobody knows what they mean."""
    cv2.imwrite(str(tmp_path / 'a.png'), NUMBERS)
    with pytest.raises(StoreError, match=r'a\.png has 16 bit numbers, and table\.json is missing'):
        LabelImages(tmp_path).of('a')

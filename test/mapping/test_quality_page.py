# SPDX-License-Identifier: Apache-2.0
"""The page about a map's quality says what its document says."""

import pytest

from rocsafe_mapping.products.quality_page import quality_page


@pytest.fixture
def document():
    """A document as `quality` makes it, with what the page needs."""
    bias = {'bias_east_m': -0.004, 'bias_north_m': -1.26, 'bias_up_m': 0.0}
    return {
        'is_georeferenced': True,
        'stated_error_m': {'rms': 0.093, 'largest': 0.2},
        'stated_error_with_what_stands_m': {
            'rms': 0.44,
            'ground': {'share': 0.45, 'rms': 0.16},
            'standing': {'share': 0.03, 'rms': 1.55},
            'untold': {'share': 0.0, 'rms': None},
        },
        'photographs': {'total': 2, 'placed_by_features': 2, 'placed_by_gps': []},
        'coverage': {'of': 'region', 'share': 0.5, 'largest_hole_m2': 4.0},
        'ground_resolution_m': 0.05,
        'epsg_code': 32629,
        'is_local': False,
        'unit': 'm',
        'control': {'points': []},
        'held_out_ties': {'count': 0},
        'seams': {'count': 0},
        'fixes': {'all': {'horizontal_rmse_m': 0.5, **bias}},
        'placements': [],
        'costs': {},
    }


def test_no_figure_has_a_sign_without_a_value(document):
    """What rounds to nothing is 0.00, never -0.00; other signs stay."""
    page = quality_page(document)
    assert '-0.00' not in page
    assert '0.00, -1.26, 0.00 m' in page


def test_what_stands_up_is_told_by_kind(document):
    """Each kind of place that the map has with its share and error, and the picture of them."""
    page = quality_page(document, error_picture='error.png')
    assert '<td class="n">45.0 %</td><td class="n">0.16</td>' in page
    assert '<td class="n">3.0 %</td><td class="n">1.55</td>' in page
    assert 'not alike in two</td>' not in page
    assert 'src="error.png"' in page
    assert 'error of the map' not in quality_page(document)

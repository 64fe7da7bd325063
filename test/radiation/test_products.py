# SPDX-License-Identifier: Apache-2.0
"""Cordons enclose what exceeds their level, and the dose map is that of the sources."""

import json
import math
from xml.etree import ElementTree

import numpy as np
import pytest
import rasterio
from rasterio.warp import transform
from shapely.geometry import Point, shape

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_hazard.area_kml import KML_NAMESPACE
from rocsafe_radiation.localization.estimates import Localization, SourceEstimate
from rocsafe_radiation.physics.kernel import Kernel
from rocsafe_radiation.products.assessment import AssessmentOptions, assess
from rocsafe_radiation.products.cordon import cordons
from rocsafe_radiation.products.dose_map import DoseMap, dose_map
from rocsafe_radiation.products.files import write_products

from .simulated_survey import LOSSLESS, survey

FRAME = LocalFrame(GeoPosition(53.28, -9.06, 66.0))
PAPER = Kernel(is_lossy=False)


def found(strength_usvh=9250.0, position_std_m=0.0, log_std=0.0):
    """Return one source at 120 m east, 170 m north, 1 m above the ground's map."""
    source = SourceEstimate(
        position_enu_m=np.array([120.0, 170.0, 0.0]),
        dose_rate_at_1m_usvh=strength_usvh,
        joint_covariance=np.diag([position_std_m**2, position_std_m**2, 0.0, log_std**2]),
        detection_llr=100.0,
    )
    return Localization(
        sources=(source,),
        order_probabilities=(0.0, 1.0),
        background_usvh=0.1,
        background_std_usvh=0.0,
        reading_count=441,
        dispersion=0.0,
        rho=0.0,
        is_structured=False,
    )


@pytest.mark.slow
def test_the_map_is_the_field_one_metre_above_the_ground():
    """100 uSv/h lie where 9250 / d^2 + 0.1 does: 9.57 m around, at 1 m above a source at 0."""
    found_map = dose_map(found(), survey([(120.0, 170.0, 9250.0)]), PAPER, 25.0)
    inner = next(c for c in cordons(found_map, [100.0]) if c.confidence == 'mean')
    radius = math.sqrt(9250.0 / 99.9 - 1.0)
    assert inner.area.area == pytest.approx(math.pi * radius**2, rel=0.01)
    assert found_map.std_usvh.max() == pytest.approx(0.0, abs=1e-6)


@pytest.mark.slow
def test_doubt_makes_the_upper_cordon_larger():
    """Of the strength by 30 %: its radius grows by exp(1.645 * 0.3 / 2)."""
    found_map = dose_map(found(log_std=0.3), survey([(120.0, 170.0, 9250.0)]), PAPER, 25.0)
    mean, upper = cordons(found_map, [25.0])
    growth = math.sqrt(upper.area.area / mean.area.area)
    assert growth == pytest.approx(math.exp(1.645 * 0.3 / 2.0), rel=0.1)
    assert upper.area.buffer(1e-6).contains(mean.area)


@pytest.mark.slow
def test_the_same_seed_makes_the_same_map():
    """Nothing else is random."""
    readings = survey([(120.0, 170.0, 1e3)])
    first, second = (dose_map(found(1e3, 2.0, 0.2), readings, PAPER, 25.0) for _ in range(2))
    assert np.array_equal(first.upper_usvh, second.upper_usvh)


def test_a_level_of_nothing_is_refused():
    """Naming it."""
    flat = DoseMap(
        corner_m=(0.0, 0.0),
        cell_m=1.0,
        mean_usvh=np.ones((3, 3)),
        std_usvh=np.zeros((3, 3)),
        upper_usvh=np.ones((3, 3)),
    )
    with pytest.raises(ValueError, match='level_usvh = 0'):
        cordons(flat, [0.0])


@pytest.mark.slow
def test_files_agree_on_where_the_source_is(tmp_path):
    """GeoTIFF, GeoJSON and KML, in degrees."""
    readings = survey([(120.0, 170.0, 9250.0)])
    options = AssessmentOptions(known=LOSSLESS)
    write_products(tmp_path, assess(readings, options), FRAME)
    place = FRAME.position_of([120.0, 170.0, 0.0])
    areas = json.loads((tmp_path / 'cordons.geojson').read_text())['features']
    hundred = next(a for a in areas if a['properties']['level_usv_h'] == 100.0)
    assert shape(hundred['geometry']).contains(Point(place.longitude_deg, place.latitude_deg))
    ring = hundred['geometry']['coordinates'][0][0]
    assert ring[0] == ring[-1]
    assert hundred['properties']['stay_time_h']['public_year_1_msv'] == 10.0
    with rasterio.open(tmp_path / 'dose_map.tif') as raster:
        (x,), (y,) = transform(
            'EPSG:4326', raster.crs, [place.longitude_deg], [place.latitude_deg]
        )
        assert (x, y) == pytest.approx((120.0, 170.0), abs=0.01)
        (value,) = next(raster.sample([(x, y)], 1))
        assert value > 1000.0
        assert raster.dtypes == ('float32',) * 3
    kml = ElementTree.parse(tmp_path / 'cordons.kml')  # noqa: S314 - our own file
    names = [element.text for element in kml.iter(f'{{{KML_NAMESPACE}}}name')]
    assert '100 µSv/h, mean' in names
    (told, *_) = [
        mark.findtext(f'{{{KML_NAMESPACE}}}description')
        for mark in kml.iter(f'{{{KML_NAMESPACE}}}Placemark')
        if '100 µSv/h' in mark.findtext(f'{{{KML_NAMESPACE}}}name')
    ]
    assert told.startswith('inner cordon (IAEA); ')
    assert '; 1 mSv after 10 h at its edge' in told

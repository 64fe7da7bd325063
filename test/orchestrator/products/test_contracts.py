# SPDX-License-Identifier: Apache-2.0
"""What other packages write, the products read: their own writers are the judges."""

import json
import math

import pytest

from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_geo.position import GeoPosition
from rocsafe_orchestrator.products.photographs import read_photographs
from rocsafe_orchestrator.products.plan_file import read_plan


@pytest.fixture(scope='module')
def planned():
    """A small plan, made by the planner."""
    from rocsafe_geo.regions.area import SurveyArea
    from rocsafe_planner.plan.request import SurveyRequest
    from rocsafe_planner.plan.survey_options import CoverageOptions
    from rocsafe_planner.plan.survey_region import SurveyRegion
    from rocsafe_planner.plan.vehicle import Vehicle
    from rocsafe_planner.planning import plan_survey

    corners = [(53.28, -9.06), (53.281, -9.06), (53.281, -9.062), (53.28, -9.062)]
    boundary = tuple(GeoPosition(*corner) for corner in corners)
    request = SurveyRequest(
        regions=(SurveyRegion(area=SurveyArea(boundary=boundary, name='yard')),),
        camera=PinholeCamera(math.radians(60.0), 640, 480),
        vehicles=(
            Vehicle(
                name='rav1', home=GeoPosition(53.2795, -9.061, 66.0), cruise_speed_mps=8.0,
                acceleration_mps2=2.0, climb_rate_mps=2.5, descent_rate_mps=1.5, hover_s=1.0,
                endurance_s=1500.0,
            ),
        ),
        coverage=CoverageOptions(height_agl_m=32.0),
    )  # fmt: skip
    return plan_survey(request)


def test_plan_of_the_planner_is_read_whole(planned, tmp_path):
    """Figures, routes and region are those of the plan."""
    from rocsafe_planner.plan.plan_json import plan_document

    path = tmp_path / 'plan.json'
    path.write_text(json.dumps(plan_document(planned)), encoding='utf-8')
    plan = read_plan(path)
    assert plan.makespan_s == planned.makespan_s
    assert plan.gap_fraction == planned.gap_fraction
    assert plan.covered_fraction == planned.covered_fraction
    assert plan.region.boundary == planned.request.regions[0].area.boundary
    assert [v.position for v in plan.routes[0].viewpoints] == [
        v.position for v in planned.routes[0].viewpoints
    ]


@pytest.mark.parametrize(
    ('text', 'told'),
    [('{', 'Expecting'), ('{"format_version": 1}', 'format 1'), ('{}', "'format_version'")],
)
def test_what_is_no_plan_is_refused(tmp_path, text, told):
    """The error names the file and what is wrong."""
    path = tmp_path / 'plan.json'
    path.write_text(text, encoding='utf-8')
    with pytest.raises(ValueError, match=f'plan.json.*{told}'):
        read_plan(path)


def test_photographs_of_the_store_are_read(tmp_path):
    """A photograph stored by the collector's store is found with its place and aim."""
    import hashlib
    import io

    from PIL import Image

    from rocsafe_mapping.photographs.shot import Intrinsics, ShotRecord
    from rocsafe_mapping.store.store import ImageStore

    stream = io.BytesIO()
    Image.new('RGB', (64, 48), 'green').save(stream, 'JPEG')
    image = stream.getvalue()
    store = ImageStore(tmp_path / 'images')
    store.put(
        ShotRecord(
            shot_id='rav1-00007', vehicle='rav1', sequence=7, viewpoint_id=3, time_ns=5,
            latitude_deg=53.28, longitude_deg=-9.06, altitude_m=98.0,
            position_covariance_m2=(0.0,) * 9, height_agl_m=32.0,
            orientation_xyzw=(-1.0, 0.0, 0.0, 0.0), orientation_covariance_rad2=(0.0,) * 9,
            camera=Intrinsics(
                width_px=64, height_px=48, fx_px=55.4256, fy_px=55.4256, cx_px=31.5, cy_px=23.5
            ),
            sha256=hashlib.sha256(image).hexdigest(),
        ),
        image,
    )  # fmt: skip
    store.close()
    (photograph,) = read_photographs(tmp_path / 'images')
    assert photograph.path.is_file()
    assert (photograph.vehicle, photograph.viewpoint_id, photograph.time_ns) == ('rav1', 3, 5)
    assert photograph.position == GeoPosition(53.28, -9.06, 98.0)
    assert photograph.aim.camera.horizontal_fov_rad == pytest.approx(math.radians(60.0), abs=1e-5)


@pytest.mark.parametrize('line', ['', 'rubbish', '{"shot_id": "../../etc/passwd"}', '[]'])
def test_damaged_manifest_lines_are_passed_over(tmp_path, line):
    """Nothing outside the store is looked at."""
    (tmp_path / 'manifest.jsonl').write_text(line + '\n', encoding='utf-8')
    assert read_photographs(tmp_path) == ()

# SPDX-License-Identifier: Apache-2.0
"""What other packages write, the products read: their own writers are the judges."""

import math

import pytest

from rocsafe_geo.position import GeoPosition
from rocsafe_orchestrator.products.photographs import read_photographs


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

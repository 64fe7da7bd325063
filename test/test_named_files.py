# SPDX-License-Identifier: Apache-2.0
"""No reader of files that a user names waits for ever on a pipe."""

import os

import pytest

from rocsafe_dispersion.estimator_options import estimator_options
from rocsafe_dispersion.identification.procedures import read_sections
from rocsafe_geo.regions.area_files import read_area
from rocsafe_geo.storage.csv_rows import read_table
from rocsafe_geo.storage.secret_file import read_token
from rocsafe_geo.storage.yaml_source import read_yaml
from rocsafe_ground.evidence.evidence_file import read_evidence
from rocsafe_mapping.photographs.label_images import LabelImages
from rocsafe_mapping.photographs.survey_file import read_text
from rocsafe_planner.plan.plan_reading import read_plan
from rocsafe_radiation.readings.readings_file import read_readings
from rocsafe_scene.mesh.mesh_file import read_mesh
from rocsafe_scene.scene.scene_file import read_scene

READERS = {
    'pipe.kml': read_area,
    'pipe.geojson': read_area,
    'pipe.csv': lambda path: read_table(path, list, 10),
    'readings.csv': read_readings,
    'pipe.yaml': read_yaml,
    'scene.yaml': read_scene,
    'mesh.obj': lambda path: read_mesh(str(path)),
    'plan.json': read_plan,
    'evidence.geojson': read_evidence,
    'gcp_list.txt': read_text,
    'token': read_token,
    'estimator.yaml': estimator_options,
    'procedure.md': lambda path: read_sections(path.parent),
    'table.json': lambda path: LabelImages(path.parent),
}


@pytest.mark.timeout(10)
@pytest.mark.parametrize('name', READERS)
def test_a_pipe_is_refused_at_once(tmp_path, name):
    """In one line that names it."""
    os.mkfifo(tmp_path / name, 0o600)
    with pytest.raises(Exception, match='must be a file') as refusal:
        READERS[name](tmp_path / name)
    assert name in str(refusal.value)
    assert '\n' not in str(refusal.value)

# SPDX-License-Identifier: Apache-2.0
"""Scene files: those we ship are sound, and each mistake is told in one clear line."""

import json
import struct
from pathlib import Path

import numpy as np
import pytest
import yaml

from rocsafe_scene.errors import SceneError
from rocsafe_scene.mesh.mesh_file import read_mesh
from rocsafe_scene.scene.building import check, ground_works
from rocsafe_scene.scene.scene_file import read_scene

SCENES = sorted((Path(__file__).resolve().parents[2] / 'config' / 'scenes').glob('*.yaml'))
CAR = {'name': 'car', 'make': 'car', 'at': [1.0, 2.0]}
MISTAKES = [
    ({'objects': [{**CAR, 'colour': 'red'}]}, r'scene.yaml: objects\[0\].colour: unknown key'),
    ({'objects': [{**CAR, 'make': 'boat'}]}, "objects: car: make is 'boat': must be one of"),
    ({'objects': [{**CAR, 'class': 'boat'}]}, r"objects\[0\].class = 'boat': class is 'boat'"),
    ({'objects': [{**CAR, 'at': [900.0, 2.0]}]}, 'objects: car: stands at east 900.0 m'),
    ({'objects': [CAR, CAR]}, 'objects: car: the name is taken'),
    ({'objects': [{**CAR, 'with': {'wheels': 3}}]}, 'objects: car: with.wheels: unknown option'),
    ({'objects': [{'name': 'car', 'make': 'car'}]}, 'must say at, position, line or scatter'),
    ({'objects': [{'name': 'car', 'at': [0.0, 0.0]}]}, 'objects: car: must say make or mesh'),
    ({'objects': [{**CAR, 'mesh': 'gone.glb'}]}, 'gone.glb: No such file or directory'),
    ({'objects': [{**CAR, 'mesh': 'gone.stl'}]}, 'gone.stl: must be a .glb or .obj file'),
    ({'objects': [{**CAR, 'fill': 2.0}]}, r'objects\[0\].fill = 2.0'),
    ({'ground': [{'name': 'x', 'kind': 'lava', 'line': [[0, 0], [1, 1]]}]}, "kind is 'lava'"),
    ({'ground': [{'name': 'x', 'kind': 'road'}]}, 'ground: x: road must say line'),
    ({'light': {'weather': 'hail'}}, "light.weather = 'hail'"),
]


def written(folder: Path, content: dict) -> Path:
    """Write a scene file and return its path."""
    path = folder / 'scene.yaml'
    path.write_text(yaml.safe_dump({'name': 'test', **content}))
    return path


@pytest.mark.slow
@pytest.mark.parametrize('path', SCENES, ids=lambda path: path.stem)
def test_every_scene_we_ship_is_sound(path):
    """All its ground and all its objects can be made; numbers and names are unique."""
    description = read_scene(path)
    assert ground_works(description, description.seed)
    objects = check(description)
    assert len({thing.name for thing in objects}) == len(objects)
    assert [thing.number for thing in objects] == list(range(2, 2 + len(objects)))


@pytest.mark.parametrize(('content', 'text'), MISTAKES)
def test_each_mistake_is_one_clear_line(tmp_path, content, text):
    """The line names the place, the value and what would be right."""
    path = written(tmp_path, content)
    with pytest.raises(SceneError, match=text) as caught:
        check(read_scene(path))
    assert len(str(caught.value).splitlines()) == 1


def test_a_file_that_is_no_yaml_is_refused(tmp_path):
    """One line, naming the file."""
    path = tmp_path / 'scene.yaml'
    path.write_text('name: [')
    with pytest.raises(SceneError, match=r'scene.yaml: is no YAML'):
        read_scene(path)


def test_an_obj_takes_the_place_of_a_mesh_and_keeps_name_and_label(tmp_path):
    """Only the shape changes."""
    (tmp_path / 'wedge.obj').write_text(
        'v 0 0 0\nv 2 0 0\nv 0 2 0\nv 0 0 2\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n'
    )
    (thing,) = check(read_scene(written(tmp_path, {'objects': [{**CAR, 'mesh': 'wedge.obj'}]})))
    assert (thing.name, thing.label, thing.triangle_count) == ('car', 'car', 4)


def glb(points: np.ndarray, translation: list[float]) -> bytes:
    """Return a glTF binary of one triangle over `points` (3, 3)."""
    binary = points.astype('<f4').tobytes()
    document = {
        'scenes': [{'nodes': [0]}],
        'nodes': [{'mesh': 0, 'translation': translation}],
        'meshes': [{'primitives': [{'attributes': {'POSITION': 0}}]}],
        'accessors': [{'bufferView': 0, 'componentType': 5126, 'count': 3, 'type': 'VEC3'}],
        'bufferViews': [{'buffer': 0, 'byteLength': len(binary)}],
    }
    text = json.dumps(document).encode()
    text += b' ' * (-len(text) % 4)
    chunks = struct.pack('<II', len(text), 0x4E4F534A) + text
    chunks += struct.pack('<II', len(binary), 0x004E4942) + binary
    return b'glTF' + struct.pack('<II', 2, 12 + len(chunks)) + chunks


def test_glb_is_turned_from_y_up_to_z_up(tmp_path):
    """The y of glTF becomes up, its z becomes ahead; a node's shift counts."""
    path = tmp_path / 'triangle.glb'
    path.write_bytes(glb(np.array([[0.0, 3.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]), [0, 1, 0]))
    assert np.allclose(read_mesh(str(path)).points, [[0, 0, 4], [0, 1, 1], [1, 0, 1]])


def test_a_cut_off_glb_is_told_in_one_line(tmp_path):
    """A damaged file is named, with no traceback."""
    path = tmp_path / 'cut.glb'
    path.write_bytes(glb(np.eye(3), [0, 0, 0])[:-20])
    with pytest.raises(SceneError, match='is damaged'):
        read_mesh(str(path))


def test_the_documentation_shows_every_scene():
    """From above, aslant, as truth and as a whole, in less than 250 kB each."""
    pictures = Path(__file__).resolve().parents[2] / 'docs' / 'scenes'
    for scene in SCENES:
        for view in ('nadir', 'oblique', 'truth', 'overview'):
            assert 20_000 < (pictures / f'{scene.stem}_{view}.jpg').stat().st_size < 250_000

# SPDX-License-Identifier: Apache-2.0
"""Data sets as others read them: COCO, YOLO, masks, depth, Exif; made again, continued."""

import io
import json
import sys
from dataclasses import replace

import cv2
import numpy as np
import pytest
from PIL import Image
from test.scene.scenes import PLANT, THINGS, describe, small_environment

pytest.importorskip('panda3d', reason='panda3d is not installed')
from rocsafe_dataset.dataset_camera import DatasetCamera
from rocsafe_dataset.dataset_command import main
from rocsafe_dataset.errors import DatasetError
from rocsafe_dataset.folder.files import DatasetFolder
from rocsafe_dataset.folder.summary import finish
from rocsafe_dataset.options import SPLITS, DatasetOptions
from rocsafe_dataset.worker_pool import claim_folder, open_tasks
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_scene.engine.silhouettes import batches
from rocsafe_scene.errors import EngineError
from rocsafe_scene.graphics.lens import looking
from rocsafe_scene.graphics.pipe import open_pipe
from rocsafe_scene.mesh.classes import CLASSES

pytestmark = pytest.mark.slow

OPTIONS = DatasetOptions(
    count=10, seed=2, size_px=(160, 120), height_m=(12.0, 25.0), per_arrangement=5,
    weathers=('clear', 'overcast'), splits=(0.5, 0.25, 0.25), least_pixels=6,
)  # fmt: skip


TENTS = {
    'name': 'tents',
    'make': 'tent',
    'scatter': {
        'count': 60,
        'outline': ((-70.0, -60.0), (70.0, -60.0), (70.0, 60.0), (-70.0, 60.0)),
    },
}
SCENE = (*THINGS, PLANT, TENTS)


@pytest.fixture(scope='module')
def photographer(tmp_path_factory):
    """Return a photographer of a small scene, and its folder."""
    try:
        open_pipe()
    except EngineError as error:
        pytest.skip(str(error))
    folder = DatasetFolder(path=tmp_path_factory.mktemp('data') / 'set', options=OPTIONS)
    return DatasetCamera(small_environment(*SCENE), folder), folder


@pytest.fixture(scope='module')
def dataset(photographer):
    """Return the folder of a finished data set."""
    worker, folder = photographer
    claim_folder(folder, describe(*SCENE))
    for arrangement, numbers in open_tasks(folder):
        assert list(worker.photograph(arrangement, numbers)) == list(numbers)
    counts = finish(folder, 'test')
    assert counts.total() >= 10
    return folder


def records(folder):
    """Return all records."""
    return [json.loads(folder.record(number).read_bytes()) for number in range(OPTIONS.count)]


@pytest.mark.all
def test_pycocotools_reads_the_annotations(dataset):
    """Masks, boxes and areas are those of the instance pictures."""
    coco = pytest.importorskip('pycocotools.coco')
    seen = 0
    for split in SPLITS:
        api = coco.COCO(str(dataset.path / 'annotations' / f'instances_{split}.json'))
        for image in api.loadImgs(api.getImgIds()):
            numbers = cv2.imread(
                str(dataset.path / 'masks' / split / image['file_name']).replace('.jpg', '.png'),
                cv2.IMREAD_UNCHANGED,
            )
            for found in api.loadAnns(api.getAnnIds(imgIds=image['id'])):
                mask = api.annToMask(found).astype(bool)
                assert np.array_equal(mask, numbers == found['attributes']['instance'])
                assert found['area'] == mask.sum()
                assert tuple(found['bbox']) == cv2.boundingRect(mask.astype(np.uint8))
                assert 0.0 < found['attributes']['visibility'] <= 1.0
                seen += 1
    assert seen >= 10


@pytest.mark.parametrize('kind', ['coco', 'yolo'])
def test_supervision_reads_the_data_set(dataset, kind):
    """The same pictures, classes and masks in both ways of writing."""
    supervision = pytest.importorskip('supervision')
    images = dataset.path / 'images' / 'train'
    if kind == 'coco':
        found = supervision.DetectionDataset.from_coco(
            str(images), str(dataset.path / 'annotations' / 'instances_train.json'),
            force_masks=True,
        )  # fmt: skip
    else:
        found = supervision.DetectionDataset.from_yolo(
            str(images), str(dataset.path / 'labels' / 'train'), str(dataset.path / 'data.yaml'),
            force_masks=True,
        )  # fmt: skip
    expected = {r['file'].split('/')[-1]: r for r in records(dataset) if r['split'] == 'train'}
    assert len(found) == len(expected)
    for path, _, detections in found:
        rows = expected[path.split('/')[-1]]['annotations']
        assert len(detections) == len(rows)
        areas = np.array([row['area'] for row in rows])
        if kind == 'coco':
            assert [detections.mask[k].sum() for k in range(len(rows))] == areas.tolist()
        elif len(rows):
            large = areas > 200
            drawn = np.array([detections.mask[k].sum() for k in range(len(rows))])
            assert np.all(np.abs(drawn[large] / areas[large] - 1.0) < 0.35)


def test_a_picture_says_where_it_was_taken(dataset):
    """Exif and XMP as in the image store; depth and classes fit the picture."""
    record = records(dataset)[0]
    with Image.open(dataset.path / record['file']) as image:
        gps = image.getexif().get_ifd(0x8825)
        assert b'drone-dji:GimbalPitchDegree' in image.info['xmp']
    degrees, minutes, seconds = (float(value) for value in gps[2])
    place = LocalFrame(GeoPosition(0.0, 0.0, 0.0)).position_of(np.array(record['position_enu_m']))
    assert degrees + minutes / 60 + seconds / 3600 == pytest.approx(abs(place.latitude_deg))
    stem = f'{record["split"]}/{record["number"]:06d}'
    depth = cv2.imread(str(dataset.path / f'depth/{stem}.tiff'), cv2.IMREAD_UNCHANGED)
    classes = cv2.imread(str(dataset.path / f'semantic/{stem}.png'), cv2.IMREAD_UNCHANGED)
    assert depth.dtype == np.float32
    assert depth.shape == classes.shape == (120, 160)
    assert classes.max() < len(CLASSES)
    assert depth[classes > 0].min() > 1.0


def test_png_pictures_carry_the_same_records(photographer):
    """Exif and XMP in PNG's own chunks; the pixels come back unchanged."""
    worker, folder = photographer
    png = DatasetFolder(
        path=folder.path.parent / 'png', options=replace(OPTIONS, image_format='png')
    )
    worker._folder = png
    assert list(worker.photograph(0, [0])) == [0]
    worker._folder = folder
    data = next((png.path / 'images').rglob('*.png')).read_bytes()
    with Image.open(io.BytesIO(data)) as image:
        image.load()
        assert image.getexif().get_ifd(0x8825)[18] == 'WGS-84'
        assert 'drone-dji:GimbalPitchDegree' in image.info['XML:com.adobe.xmp']


def test_a_picture_is_the_same_whenever_it_is_made(photographer, dataset):
    """Alone, after others: byte for byte, with its masks and annotations."""
    worker, _ = photographer
    names = {7: 'records/000007.json', 3: 'records/000003.json'}
    chosen = {
        number: json.loads((dataset.path / name).read_bytes()) for number, name in names.items()
    }
    files = [dataset.path / record['file'] for record in chosen.values()]
    files += [dataset.path / name for name in names.values()]
    files += list((dataset.path / 'masks').rglob('00000[37].png'))
    before = [path.read_bytes() for path in files]
    for path in files:
        path.unlink()
    assert open_tasks(dataset) == [(0, (3,)), (1, (7,))]
    for arrangement, numbers in reversed(open_tasks(dataset)):
        list(worker.photograph(arrangement, numbers))
    assert [path.read_bytes() for path in files] == before


def test_visibility_is_what_others_leave(photographer):
    """As many pixels as are seen, by those of the thing standing alone."""
    worker, _ = photographer
    renderer, shares = worker._renderer, worker._silhouettes
    environment = worker._environment
    eye = np.array([20.0, -30.0, 7.0])
    pose = eye, looking(np.array([4.0, -2.0, 2.0]) - eye)
    renderer.graph.arrange(environment.objects)
    together = worker._camera.expose(*pose).numbers
    bounds = {thing.number: thing.bounds for thing in environment.objects}
    bounds = {k: b for k, b in bounds.items() if (together == k).any()}
    found = shares.visible_shares(together, bounds, pose)
    assert min(found.values()) < 0.9
    graph = renderer.graph
    for number in sorted(found, key=found.get)[:6]:
        graph.arrange([thing for thing in environment.objects if thing.number == number])
        alone = (worker._camera.expose(*pose).numbers == number).sum()
        expected = (together == number).sum() / alone
        assert found[number] == pytest.approx(expected, abs=1e-9)
    graph.arrange(environment.objects)


def test_batches_never_overlap():
    """And hold every box once."""
    rng = np.random.default_rng(3)
    corners = rng.integers(0, 80, (60, 2))
    sizes = rng.integers(1, 30, (60, 2))
    boxes = {
        k: (*c.tolist(), *(c + s).tolist())
        for k, (c, s) in enumerate(zip(corners, sizes, strict=True))
    }
    groups = batches(boxes)
    assert sorted(k for group in groups for k in group) == list(range(60))
    for group in groups:
        drawn = np.zeros((120, 120), int)
        for k in group:
            left, top, right, bottom = boxes[k]
            drawn[top:bottom, left:right] += 1
        assert drawn.max() == 1


def test_a_folder_is_claimed_once(tmp_path):
    """Another data set's, or someone's files, are never overwritten."""
    folder = DatasetFolder(path=tmp_path / 'a', options=OPTIONS)
    claim_folder(folder, describe(*THINGS))
    claim_folder(folder, describe(*THINGS))
    with pytest.raises(DatasetError, match='holds a data set with other options'):
        claim_folder(replace(folder, options=replace(OPTIONS, seed=9)), describe(*THINGS))
    with pytest.raises(DatasetError, match='holds a data set with other scene'):
        claim_folder(folder, describe(PLANT))
    (tmp_path / 'mine.txt').write_text('kept')
    with pytest.raises(DatasetError, match='is not empty and holds no data set'):
        claim_folder(DatasetFolder(path=tmp_path, options=OPTIONS), describe(*THINGS))


def test_mistakes_on_the_command_line_are_one_line(tmp_path, capsys):
    """What, which value, which limit; exit code 2."""
    scene = tmp_path / 'scene.yaml'
    scene.write_text('name: small\n')
    assert main([str(scene), '--count', '0', '--out', str(tmp_path / 'x')]) == 2
    line = capsys.readouterr().err
    assert line.startswith('rocsafe: count')
    assert line.count('\n') == 1
    assert main([str(tmp_path / 'no.yaml'), '--count', '2', '--out', str(tmp_path / 'x')]) == 2
    assert 'No such file' in capsys.readouterr().err
    assert 'rocsafe_dataset' in sys.modules

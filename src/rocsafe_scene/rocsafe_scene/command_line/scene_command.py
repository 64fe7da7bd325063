# SPDX-License-Identifier: Apache-2.0
"""``rocsafe scene``: check, list and render scene files."""

import argparse
import math
import sys
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from rocsafe_geo.argument import image_size
from rocsafe_geo.pinhole import PinholeCamera, rotation_enu_from_optical
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.solids.solids_file import write_solids
from rocsafe_scene.command_line.label_images import truth_sheet
from rocsafe_scene.command_line.plume_overview import draw_plume, read_plume
from rocsafe_scene.command_line.routes_overview import RunRoutes, draw_routes, read_run
from rocsafe_scene.command_line.scene_arguments import exit_code_of
from rocsafe_scene.errors import SceneError
from rocsafe_scene.ground.height_file import write_heights
from rocsafe_scene.mesh.mesh import Floats
from rocsafe_scene.scene.building import check, ground_works, terrain_of
from rocsafe_scene.scene.description import SceneDescription
from rocsafe_scene.scene.map_cache import default_folder
from rocsafe_scene.scene.placing import to_world
from rocsafe_scene.scene.scene_file import read_scene
from rocsafe_scene.scene.sunlight import WEATHERS
from rocsafe_scene.solids.solids_export import solids_of

Command = Callable[[argparse.Namespace], None]


@dataclass(frozen=True, slots=True, kw_only=True)
class View:
    """Camera position, target and size of an image; metres in the scene's own frame."""

    eye: tuple[float, float, float]
    target: tuple[float, float, float] | None
    size_px: tuple[int, int]
    fov_deg: float


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; return its exit code."""
    arguments = _parser().parse_args(argv)
    return exit_code_of(lambda: arguments.run(arguments))


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='rocsafe scene',
        description='Check, list and render the scenes that simulated cameras see.',
        epilog='`rocsafe scene show SCENARIO` looks at a mission while it runs.',
    )
    commands = parser.add_subparsers(title='commands', required=True, metavar='COMMAND')
    checking = commands.add_parser('check', help='check a scene file, and tell what is in it')
    checking.add_argument('scene', type=Path, metavar='SCENE', help='scene file (YAML)')
    checking.set_defaults(run=_check)
    listing = commands.add_parser('list', help='list every object: number, name, class, place')
    listing.add_argument('scene', type=Path, metavar='SCENE', help='scene file (YAML)')
    listing.set_defaults(run=_list)
    heights = commands.add_parser('heights', help='write the ground heights as a GeoTIFF')
    _add_export(heights, 'heights.tif', _heights)
    solids = commands.add_parser('solids', help='write the solid things, for hazard nodes')
    _add_export(solids, 'solids.npz', _solids)
    _add_render(commands)
    return parser


def _add_export(parser: argparse.ArgumentParser, file: str, run: Command) -> None:
    """Add the arguments of a command that writes `file` about the origin of a mission."""
    parser.add_argument('scene', type=Path, metavar='SCENE', help='scene file (YAML)')
    parser.add_argument(
        '--out', type=Path, default=Path(file), metavar='FILE',
        help=f'file to write (default: {file})',
    )  # fmt: skip
    parser.add_argument(
        '--origin',
        type=_triple,
        metavar='LAT,LON,ALT',
        help="origin of the mission (default: the scene's place)",
    )
    parser.add_argument(
        '--seed', type=int, metavar='N', help="seed of the mission (default: the scene's)"
    )
    parser.set_defaults(run=run)


def _add_render(commands: 'argparse._SubParsersAction[argparse.ArgumentParser]') -> None:
    parser = commands.add_parser('render', help='render an image of a scene')
    parser.add_argument('scene', type=Path, metavar='SCENE', help='scene file (YAML)')
    parser.add_argument(
        '--out', type=Path, default=Path('scene.png'), metavar='FILE',
        help='image to write (default: scene.png)',
    )  # fmt: skip
    parser.add_argument(
        '--eye',
        type=_triple,
        default=(0.0, -60.0, 35.0),
        metavar='X,Y,Z',
        help='place of the camera: metres in the frame of the scene, Z above its ground '
        '(default: 0,-60,35)',
    )
    parser.add_argument(
        '--target', type=_triple, default=(0.0, 5.0, 0.0), metavar='X,Y,Z',
        help='place at which the camera looks (default: 0,5,0)',
    )  # fmt: skip
    parser.add_argument('--nadir', action='store_true', help='look straight down')
    parser.add_argument(
        '--size', type=image_size, default=(1280, 800), metavar='WxH',
        help='width and height of the image, pixels (default: 1280x800)',
    )  # fmt: skip
    parser.add_argument(
        '--fov', type=float, default=60.0, metavar='DEG',
        help='field of view across the width, degrees (default: 60)',
    )  # fmt: skip
    parser.add_argument(
        '--weather', choices=tuple(WEATHERS), help="weather in place of the scene's"
    )
    parser.add_argument(
        '--overview',
        type=Path,
        metavar='RUN_DIR',
        help='draw the planned and flown routes of a finished run',
    )
    parser.add_argument(
        '--truth',
        action='store_true',
        help='also write classes, instances, depth and normals',
    )
    parser.add_argument(
        '--quality',
        type=int,
        default=2,
        metavar='N',
        help='1 to 4: draws N x N as many pixels (default: 2)',
    )
    parser.set_defaults(run=_render)  # fmt: skip


def _triple(text: str) -> tuple[float, float, float]:
    try:
        x, y, z = (float(part) for part in text.split(','))
    except ValueError:
        raise argparse.ArgumentTypeError(f'{text}: must be three numbers, X,Y,Z') from None
    return x, y, z


def _check(arguments: argparse.Namespace) -> None:
    description = read_scene(arguments.scene)
    objects = check(description)
    triangles = sum(thing.triangle_count for thing in objects)
    works = len(ground_works(description, description.seed))
    lines = [f'{description.name}: {description.description}'.rstrip(': ')]
    lines.append(f'{len(objects)} objects of {triangles} triangles, {works} kinds of ground')
    counts = Counter(thing.label for thing in objects)
    lines.append(', '.join(f'{count} {label}' for label, count in counts.most_common()))
    sys.stdout.write('\n'.join(lines) + '\n')


def _list(arguments: argparse.Namespace) -> None:
    rows = ['number  class         east_m  north_m    up_m  name']
    for thing in check(read_scene(arguments.scene)):
        east, north, up = thing.bounds.mean(axis=0).tolist()
        place = f'{east:6.1f}  {north:7.1f}  {up:6.1f}'
        rows.append(f'{thing.number:6d}  {thing.label:12s}  {place}  {thing.name}')
    sys.stdout.write('\n'.join(rows) + '\n')


def _heights(arguments: argparse.Namespace) -> None:
    description = read_scene(arguments.scene)
    seed, origin = _mission(arguments, description)
    write_heights(arguments.out, terrain_of(description, seed, origin), origin)
    sys.stdout.write(f'{arguments.out}\n')


def _solids(arguments: argparse.Namespace) -> None:
    description = read_scene(arguments.scene)
    solids = solids_of(description, *_mission(arguments, description))
    try:
        write_solids(arguments.out, solids)
    except OSError as error:
        raise SceneError(f'--out = {arguments.out}: {error.strerror}') from error
    sys.stdout.write(f'{arguments.out}\n')


def _mission(
    arguments: argparse.Namespace, description: SceneDescription
) -> tuple[int, GeoPosition]:
    """Return seed and origin of the mission: those given, else those of the scene."""
    seed = description.seed if arguments.seed is None else arguments.seed
    place = description.place
    scene = (place.latitude_deg, place.longitude_deg, place.altitude_m)
    try:
        return seed, GeoPosition(*(arguments.origin or scene))
    except ValueError as error:
        raise SceneError(f'--origin: {error}') from error


def _render(arguments: argparse.Namespace) -> None:
    description = read_scene(arguments.scene)
    if arguments.weather:
        light = description.light.model_copy(update={'weather': arguments.weather})
        description = description.model_copy(update={'light': light})
    view = View(
        eye=arguments.eye,
        target=None if arguments.nadir else arguments.target,
        size_px=arguments.size,
        fov_deg=arguments.fov,
    )
    for path in _drawn(description, view, arguments):
        sys.stdout.write(f'{path}\n')


def _drawn(description: SceneDescription, view: View, arguments: argparse.Namespace) -> list[Path]:
    # Imported here, so that check and list work without the engine.
    from rocsafe_scene.engine.oversampled_camera import OversampledCamera, open_scene

    routes = read_run(arguments.overview) if arguments.overview else None
    origin = routes.origin if routes else None
    renderer = open_scene(description, origin=origin, cache=default_folder())
    lens = PinholeCamera(math.radians(view.fov_deg), *view.size_px)
    pose = _pose_over(routes) if routes else _pose(description, view)
    frame = OversampledCamera(renderer, lens, arguments.quality).expose(*pose)
    image = frame.image
    if routes:
        plume = read_plume(arguments.overview, routes.origin)
        if plume is not None:
            image = draw_plume(image, frame.depth_m, lens, pose, plume)
        image = draw_routes(image, frame.depth_m, lens, pose, routes)
    written = [_written(arguments.out, image)]
    if arguments.truth:
        sheet = truth_sheet(frame.classes, frame.numbers, frame.depth_m, frame.normals)
        path = arguments.out.with_name(f'{arguments.out.stem}-truth{arguments.out.suffix}')
        written.append(_written(path, sheet))
    return written


def _pose_over(routes: RunRoutes) -> tuple[Floats, Floats]:
    """Return a pose in the south-west that sees all planned viewpoints."""
    from rocsafe_scene.graphics.lens import looking

    reach = max(60.0, min(routes.reach_m, 160.0))
    target = np.array([*routes.survey_middle[:2], 0.0])
    eye = target + reach * np.array([-0.5, -1.35, 1.2])
    return eye, looking(target - eye)


def _pose(description: SceneDescription, view: View) -> tuple[Floats, Floats]:
    from rocsafe_scene.graphics.lens import looking

    eye = np.array([*to_world(description, [view.eye[:2]])[0], view.eye[2]])
    if view.target is None:
        return eye, rotation_enu_from_optical(math.radians(description.yaw_deg + 90.0))
    target = np.array([*to_world(description, [view.target[:2]])[0], view.target[2]])
    if np.allclose(eye, target):
        raise SceneError(f'--target is {view.target}: must differ from --eye')
    return eye, looking(target - eye)


def _written(path: Path, image: Floats) -> Path:
    try:
        is_done = cv2.imwrite(str(path), image)
    except cv2.error:
        is_done = False
    if not is_done:
        raise SceneError(f'--out = {path}: cannot be written; must end in .png or .jpg')
    return path


if __name__ == '__main__':
    raise SystemExit(main())

# SPDX-License-Identifier: Apache-2.0
"""Quality of a map from its own data, and whether it may be called georeferenced."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from rocsafe_geo.arrays import FloatArray
from rocsafe_mapping.alignment.adjustment.rotation import tilt_and_yaw
from rocsafe_mapping.alignment.block import BY_FEATURES, BY_GPS, Placement
from rocsafe_mapping.alignment.model.photo import Photo
from rocsafe_mapping.alignment.model.state import State
from rocsafe_mapping.drawing.coarse_view import NO_PHOTO, Labels
from rocsafe_mapping.drawing.renderer import Renderer
from rocsafe_mapping.mosaic.map_alignment import Alignment, by_gps
from rocsafe_mapping.products.control_points import LEAST_FIXES, control_facts, control_violations
from rocsafe_mapping.products.coverage import coverage
from rocsafe_mapping.products.error_map import ErrorMap, error_map
from rocsafe_mapping.products.seam_shift import on_ground, seam_shifts_px

FORMAT = 'rocsafe-map-quality-1'
QUALITY_TILE_PX = 512
# Limits that a georeferenced map must keep.
LARGEST_FIX_FACTOR = 4.0
# Error of a fix, where no photograph has one.
HORIZONTAL_STD_M = 2.5
# A share of the image's width.
LARGEST_TIE_SHARE = 0.002
LARGEST_SCALE_OFF = 0.15
LARGEST_TILT_RAD = math.radians(12.0)
LARGEST_FOCAL_STDS = 3.5
LARGEST_RADIAL = 0.3
LEAST_TIED_SHARE = 0.5
NO_SCALE = (
    'nothing tells where the photographs were taken: the map has neither scale nor north, its '
    'unit is a hundredth of the flying height'
)


def quality(
    alignment: Alignment,
    state: State,
    renderer: Renderer,
    region: shapely.Polygon | None = None,
    errors: ErrorMap | None = None,
) -> dict[str, Any]:
    """Return the quality of a map as a document.

    Parameters
    ----------
    alignment, state
        Of the photographs.
    renderer
        Of the map.
    region
        That was to be covered, in local metres.
    errors
        Of the map's places; found here where they are not given.
    """
    placed_by_gps = by_gps(alignment)
    errors = errors or error_map(alignment, renderer)
    resolution_m = renderer.grid.resolution_m
    reasons = violations(alignment, state)
    return {
        'format': FORMAT,
        'is_georeferenced': not reasons,
        'why_not_georeferenced': reasons,
        'is_local': alignment.is_local,
        'unit': 'hundredth of the flying height' if alignment.is_local else 'm',
        'epsg_code': None if alignment.is_local else renderer.grid.epsg,
        'ground_resolution_m': resolution_m,
        'photographs': {
            'total': len(alignment.photos),
            'placed_by_features': len(alignment.photos) - len(placed_by_gps),
            'placed_by_gps': list(placed_by_gps),
        },
        'held_out_ties': _ties(alignment.held_out_px, resolution_of(alignment)),
        'seams': _seams(alignment, renderer),
        'fixes': _fixes(alignment),
        'control': control_facts(alignment),
        'stated_error_m': _stated(alignment),
        'stated_error_with_what_stands_m': errors.facts(),
        'ground': _ground(state),
        'height_above_told_m': _rounded(state.lifts_m),
        'lenses': {
            name: {'focal_factor': math.exp(lens.log_focal), 'k1': lens.k1, 'k2': lens.k2}
            for name, lens in sorted(state.lenses.items())
        },
        'coverage': coverage(renderer, region),
        'placements': _placements(alignment),
        'tiles': _tiles(alignment, renderer, errors),
        'costs': {},
    }


def resolution_of(alignment: Alignment) -> float:
    """Return the side of the ground that a pixel of the photographs shows, metres."""
    sizes = [
        placement.pose.centre[2] / alignment.photos[name].camera.fx_px
        for name, placement in alignment.placements.items()
    ]
    return float(np.median(sizes))


def violations(alignment: Alignment, state: State) -> list[str]:
    """Return why the map must not be called georeferenced; empty if it may."""
    tied = [n for n, p in alignment.placements.items() if p.placed_by == BY_FEATURES]
    found = [NO_SCALE] if alignment.is_local else []
    count = len(alignment.photos)
    if len(tied) < LEAST_TIED_SHARE * count or len(tied) < LEAST_FIXES:
        found.append(
            f'{len(tied)} of {count} photographs are tied to others: the map is as good as the '
            'single fixes'
        )
    elif max(alignment.groups) < LEAST_TIED_SHARE * count:
        found.append(
            f'the photographs fall into {len(alignment.groups)} groups that are not tied to each '
            f'other; the largest has {max(alignment.groups)} of {count}'
        )
    found += _inexact(alignment) + control_violations(alignment)
    if state.noise.fix_factor > LARGEST_FIX_FACTOR:
        found.append(
            f'fixes scatter {state.noise.fix_factor:.1f} times as far as they claim, more than '
            f'{LARGEST_FIX_FACTOR:g}'
        )
    photos, placements = alignment.photos, alignment.placements
    if tied:
        told_m = {n: photos[n].prior.centre[2] + _lift_m(photos[n], state) for n in tied}
        scale = float(np.median([placements[n].pose.centre[2] / told_m[n] for n in tied]))
        guesses = [photos[n].vertical_std_m / photos[n].prior.centre[2] for n in tied]
        if abs(scale - 1.0) > max(LARGEST_SCALE_OFF, 2.0 * float(np.median(guesses))):
            found.append(f'cameras lie {scale:.2f} times as high as measured')
        tilts = [
            np.linalg.norm(tilt_and_yaw(placements[n].pose, photos[n].prior)[0]) for n in tied
        ]
        if np.median(tilts) > LARGEST_TILT_RAD:
            found.append(f'cameras are tilted by {math.degrees(np.median(tilts)):.0f} degrees')
    stds = {photo.lens: photo.focal_std_share for photo in photos.values()}
    for name, lens in sorted(state.lenses.items()):
        if abs(lens.log_focal) > LARGEST_FOCAL_STDS * stds.get(name, math.inf):
            found.append(f'{name}: focal length is {math.exp(lens.log_focal):.2f} of the believed')
        if max(abs(lens.k1), abs(lens.k2)) > LARGEST_RADIAL:
            found.append(f'{name}: distortion k1 {lens.k1:.2f}, k2 {lens.k2:.2f} is not credible')
    return found


def _lift_m(photo: Photo, state: State) -> float:
    return state.lifts_m.get(photo.vehicle, 0.0)


def _inexact(alignment: Alignment) -> list[str]:
    """Return why the ties or the stated error forbid to call the map georeferenced."""
    found = []
    if len(alignment.held_out_px):
        off_px = float(np.median(np.linalg.norm(alignment.held_out_px, axis=1)))
        width_px = float(np.median([p.camera.width_px for p in alignment.photos.values()]))
        if off_px > LARGEST_TIE_SHARE * width_px:
            found.append(
                f'photographs disagree by {off_px:.1f} pixels, more than '
                f'{LARGEST_TIE_SHARE * width_px:.1f}'
            )
    stated_m = _stated(alignment)['rms']
    stds = [photo.horizontal_std_m for photo in alignment.photos.values() if photo.has_fix]
    usual_m = float(np.median(stds)) if stds and not alignment.is_local else HORIZONTAL_STD_M
    if not alignment.is_local and stated_m > LARGEST_FIX_FACTOR * usual_m:
        found.append(
            f'the map may be off by {stated_m:.0f} m, more than {LARGEST_FIX_FACTOR:g} times the '
            f'{usual_m:.1f} m of a fix'
        )
    return found


def _ties(held_out_px: FloatArray, resolution_m: float) -> dict[str, Any]:
    if not len(held_out_px):
        return {'count': 0}
    off = np.linalg.norm(held_out_px, axis=1)
    figures = {
        'median': float(np.median(off)),
        'p90': float(np.quantile(off, 0.9)),
        'rmse': float(np.sqrt(np.mean(off**2))),
    }
    return {
        'count': len(off),
        'px': _rounded(figures),
        'cm': _rounded({name: 100.0 * resolution_m * value for name, value in figures.items()}),
    }


def _seams(alignment: Alignment, renderer: Renderer) -> dict[str, Any]:
    """Return how far photographs disagree at seams, everywhere and where no object stands."""
    shifts, places = seam_shifts_px(renderer)
    if not len(shifts):
        return {'count': 0}
    is_ground = on_ground(places, alignment.heights)
    px = _quantiles(shifts)
    return {
        'count': len(shifts),
        'px': px,
        'cm': _rounded(
            {name: 100.0 * renderer.grid.resolution_m * value for name, value in px.items()}
        ),
        'ground_count': int(is_ground.sum()),
        'ground_px': _quantiles(shifts[is_ground]) if np.any(is_ground) else None,
    }


def _quantiles(values: FloatArray) -> dict[str, float]:
    return _rounded({'p50': float(np.median(values)), 'p95': float(np.quantile(values, 0.95))})


def _fixes(alignment: Alignment) -> dict[str, Any]:
    """Return how far the fixes are from where the photographs were put, by vehicle."""
    if alignment.is_local:
        return {}
    by_vehicle: dict[str, list[FloatArray]] = {}
    for name, placement in sorted(alignment.placements.items()):
        if placement.placed_by == BY_FEATURES and alignment.photos[name].has_fix:
            photo = alignment.photos[name]
            off = photo.prior.centre - placement.pose.centre
            by_vehicle.setdefault(photo.vehicle, []).append(off)
    document = {
        vehicle: _residuals(np.array(offs))
        | {'clock_lag_s': round(alignment.lags_s.get(vehicle, 0.0), 3)}
        for vehicle, offs in by_vehicle.items()
    }
    together = [off for offs in by_vehicle.values() for off in offs]
    return {'all': _residuals(np.array(together)), 'vehicles': document} if together else {}


def _residuals(off: FloatArray) -> dict[str, float]:
    return _rounded(
        {
            'horizontal_rmse_m': float(np.sqrt(np.mean(np.sum(off[:, :2] ** 2, axis=1)))),
            'largest_m': float(np.linalg.norm(off[:, :2], axis=1).max()),
            'bias_east_m': float(off[:, 0].mean()),
            'bias_north_m': float(off[:, 1].mean()),
            'bias_up_m': float(off[:, 2].mean()),
        }
    )


def _stated(alignment: Alignment) -> dict[str, float]:
    errors = np.array([alignment.error_m(name) for name in alignment.photos])
    return _rounded({'rms': float(np.sqrt(np.mean(errors**2))), 'largest': float(errors.max())})


def _ground(state: State) -> dict[str, Any]:
    heights = state.surface.heights_m
    return {
        'is_level': state.surface.is_level,
        'lowest_m': round(float(heights.min()), 2),
        'highest_m': round(float(heights.max()), 2),
        'standing_things_std_m': round(state.noise.clutter_std_m, 3),
    }


def _placements(alignment: Alignment) -> list[dict[str, Any]]:
    return [
        {
            'name': name,
            'placed_by': placement.placed_by,
            'error_m': round(alignment.error_m(name), 3),
            'fix_off_m': _fix_off_m(alignment.photos[name], placement),
        }
        for name, placement in sorted(alignment.placements.items())
    ]


def _fix_off_m(photo: Photo, placement: Placement) -> float | None:
    if not photo.has_fix:
        return None
    return round(float(np.linalg.norm((placement.pose.centre - photo.prior.centre)[:2])), 3)


def _tiles(alignment: Alignment, renderer: Renderer, errors: ErrorMap) -> list[dict[str, Any]]:
    """Return, for each tile of the map, what places it and how far it may be off."""
    step = max(1, round(renderer.cell_m / renderer.grid.resolution_m))
    side = max(1, QUALITY_TILE_PX // step)
    window = renderer.owner_window
    tiles = []
    for place in window.tiles(side):
        at = place.cut(window).within(window)
        off = _errors_by_name(renderer, renderer.owners[at], errors.error_m[at])
        if off:
            is_by_gps = any(alignment.placements[n].placed_by == BY_GPS for n in off)
            tiles.append({
                'row': place.row * step,
                'column': place.column * step,
                'side_px': place.height * step,
                'placed_by': BY_GPS if is_by_gps else BY_FEATURES,
                'error_m': round(max(off.values()), 3),
                'photographs': len(off),
            })  # fmt: skip
    return tiles


def _errors_by_name(
    renderer: Renderer, labels: Labels, error_m: NDArray[np.float32]
) -> dict[str, float]:
    """Return how far off each photograph is in what the map shows of it at a place."""
    numbers = sorted(set(np.unique(labels).tolist()) - {NO_PHOTO})
    squares = {renderer.names[number]: error_m[labels == number] ** 2 for number in numbers}
    return {name: float(np.sqrt(np.mean(square))) for name, square in squares.items()}


def _rounded(figures: Mapping[str, float]) -> dict[str, float]:
    return {name: round(value, 4) for name, value in figures.items()}

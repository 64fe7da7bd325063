# SPDX-License-Identifier: Apache-2.0
"""Meshes: solids have the volume and the area of their formulas, and moving keeps them."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from rocsafe_scene.mesh.coarse import clustered
from rocsafe_scene.mesh.lines import nearest_on, resampled, run_of
from rocsafe_scene.mesh.mesh import Mesh, joined, rotation_of, unit
from rocsafe_scene.mesh.shapes import ball, box, cylinder, prism, sheet, strip, tank, tube, upright
from rocsafe_scene.mesh.surfaces import Surface

ANGLES = st.floats(-180.0, 180.0)
LENGTHS = st.floats(0.3, 20.0)


def volume(mesh: Mesh) -> float:
    """Return the volume that a closed mesh encloses: a sum of tetrahedra about the origin."""
    a, b, c = (mesh.points[mesh.triangles[:, k]] for k in range(3))
    return float(np.einsum('ij,ij->i', a, np.cross(b, c)).sum() / 6.0)


def area(mesh: Mesh) -> float:
    """Return the area of all triangles."""
    a, b, c = (mesh.points[mesh.triangles[:, k]] for k in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2.0)


@given(LENGTHS, LENGTHS, LENGTHS)
@settings(max_examples=30, deadline=None)
def test_a_box_has_the_volume_of_its_sides(length, width, height):
    """But for its chamfers of 1 mm."""
    solid = box(length, width, height, bevel=0.001)
    whole = length * width * height
    edges = 4.0 * (length + width + height)
    assert whole - edges * 0.001**2 < volume(solid) <= whole * (1.0 + 1e-9)
    low, high = solid.bounds
    assert high - low == pytest.approx([length, width, height])
    assert low[2] == pytest.approx(0.0)


@pytest.mark.parametrize('segments', [12, 24, 96])
def test_a_cylinder_has_the_volume_of_its_polygon(segments):
    """Its section is a regular polygon, whose area is known."""
    radius, length = 0.7, 3.0
    section = 0.5 * segments * radius**2 * math.sin(2.0 * math.pi / segments)
    solid = cylinder(radius, length, segments, bevel=1e-4)
    assert volume(solid) == pytest.approx(section * length, rel=2e-3)


def test_round_solids_have_their_volumes():
    """Within the error of their polygons: 1 % for 48 segments."""
    assert volume(ball(2.0, 48)) == pytest.approx(4.0 / 3.0 * math.pi * 8.0, rel=0.01)
    cone = upright(1.0, 3.0, 48, top=0.5)
    assert volume(cone) == pytest.approx(math.pi * 3.0 * (1.0 + 0.5 + 0.25) / 3.0, rel=0.01)
    lying = tank(1.0, 6.0, 0.5, 48)
    spheroid = 4.0 / 3.0 * math.pi * 0.5
    assert volume(lying) == pytest.approx(math.pi * 5.0 + spheroid, rel=0.015)


def test_a_prism_has_area_times_width():
    """A gable, whose area is that of a square with a triangle on it."""
    gable = [(-2.0, 0.0), (2.0, 0.0), (2.0, 4.0), (0.0, 6.0), (-2.0, 4.0)]
    assert volume(prism(gable, 3.0)) == pytest.approx((16.0 + 4.0) * 3.0)


def test_flat_and_swept_pieces_have_their_areas():
    """A sheet has one side; a strip is its section times its length; a tube its perimeter."""
    corners = [(0.0, 0.0, 1.0), (4.0, 0.0, 1.0), (4.0, 3.0, 1.0), (0.0, 3.0, 1.0)]
    flat = sheet(corners)
    assert area(flat) == pytest.approx(12.0)
    assert np.allclose(flat.normals, (0.0, 0.0, 1.0))
    line = np.array([[0.0, 0.0, 0.0], [10.0, 0.0, 0.0]])
    kerb = strip(line, [(0.5, 0.0), (0.5, 1.0), (-0.5, 1.0), (-0.5, 0.0)])
    assert area(kerb) == pytest.approx(30.0)
    rod = tube(line, 0.2, 32)
    assert area(rod) == pytest.approx(10.0 * 32 * 2 * 0.2 * math.sin(math.pi / 32), rel=1e-6)


@given(ANGLES, ANGLES, ANGLES)
@settings(max_examples=60, deadline=None)
def test_rotations_are_those_of_scipy(yaw, pitch, roll):
    """Yaw about z, then pitch about the new y, then roll about the new x."""
    expected = Rotation.from_euler('ZYX', [yaw, pitch, roll], degrees=True).as_matrix()
    assert np.allclose(rotation_of(yaw, pitch, roll), expected, atol=1e-12)


@given(ANGLES, ANGLES, ANGLES, st.tuples(LENGTHS, LENGTHS, LENGTHS))
@settings(max_examples=30, deadline=None)
def test_moving_keeps_volume_and_scaling_multiplies_it(yaw, pitch, roll, factors):
    """Normals stay of length 1 and keep pointing outwards."""
    solid = cylinder(0.5, 2.0)
    moved = solid.turned(yaw, pitch, roll).moved(3.0, -2.0, 7.0)
    assert volume(moved) == pytest.approx(volume(solid), rel=1e-9)
    stretched = solid.scaled(*factors)
    assert volume(stretched) == pytest.approx(volume(solid) * math.prod(factors), rel=1e-9)
    for mesh in (moved, stretched):
        assert np.allclose(np.linalg.norm(mesh.normals, axis=1), 1.0)
        middle = mesh.points.mean(axis=0)
        assert (np.einsum('ij,ij->i', mesh.normals, mesh.points - middle) > -1e-9).all()


def test_inside_out_has_the_volume_with_the_other_sign():
    """Normals and winding turn together."""
    solid = box(1.0, 2.0, 3.0)
    assert volume(solid.flipped()) == pytest.approx(-volume(solid))
    assert np.array_equal(solid.flipped().normals, -solid.normals)


def test_joined_parts_add_their_volumes():
    """The triangles of each part keep their own corners."""
    parts = [box(1.0, 1.0, 1.0), ball(0.5).moved(5.0), cylinder(0.2, 2.0).turned(30.0)]
    assert volume(joined(parts)) == pytest.approx(sum(map(volume, parts)))
    with pytest.raises(ValueError, match='at least one'):
        joined([])


@pytest.mark.parametrize('cell_m', [0.05, 0.2])
def test_a_simpler_mesh_is_closed_and_hardly_smaller(cell_m):
    """It has fewer triangles, stays within a cell of the solid, and keeps its volume."""
    solid = tank(1.5, 8.0, 0.6, 64, 12)
    simple = clustered(solid, cell_m)
    assert len(simple.triangles) < len(solid.triangles)
    assert volume(simple) == pytest.approx(volume(solid), rel=2.0 * cell_m)
    assert np.abs(simple.bounds - solid.bounds).max() <= cell_m


def test_simpler_meshes_keep_surfaces_apart():
    """A corner that two surfaces share keeps the colour of each."""
    red = box(1.0, 1.0, 1.0).painted((200, 0, 0), Surface.PAINT)
    grey = box(1.0, 1.0, 1.0).moved(1.0).painted((90, 90, 90), Surface.STEEL)
    simple = clustered(joined([red, grey]), 0.3)
    kinds = {tuple(row) for row in simple.colours.tolist()}
    assert kinds == {(200, 0, 0, Surface.PAINT), (90, 90, 90, Surface.STEEL)}


def test_unit_vectors_of_zero_are_zero():
    """And all others have length 1."""
    found = unit(np.array([[0.0, 0.0, 0.0], [3.0, 4.0, 0.0]]))
    assert np.allclose(found, [[0.0, 0.0, 0.0], [0.6, 0.8, 0.0]])


def test_a_line_is_resampled_evenly():
    """Ends are kept, steps are equal, the length is that of the corners."""
    corner = np.array([[0.0, 0.0], [30.0, 0.0], [30.0, 40.0]])
    assert run_of(corner).tolist() == [0.0, 30.0, 70.0]
    line = resampled(corner, 7.0)
    assert np.allclose(line[[0, -1]], corner[[0, -1]])
    assert np.allclose(np.linalg.norm(np.diff(line, axis=0), axis=1)[:4], 7.0)
    assert len(line) == 11


@given(st.lists(st.tuples(st.floats(-50, 50), st.floats(-50, 50)), min_size=2, max_size=6))
@settings(max_examples=40, deadline=None)
def test_the_nearest_point_is_never_farther_than_any_sample(corners):
    """Compared with a line of samples 1 cm apart."""
    line = np.array(corners)
    place = np.array([[3.0, -4.0]])
    found = nearest_on(line, place)
    samples = np.concatenate(
        [a + np.linspace(0.0, 1.0, 500)[:, None] * (b - a) for a, b in pairwise(line)]
    )
    least = np.linalg.norm(samples - place, axis=1).min()
    assert found.distance_m[0] <= least + 1e-9
    assert found.distance_m[0] >= least - 0.2
    assert 0.0 <= found.along_m[0] <= run_of(line)[-1] + 1e-9

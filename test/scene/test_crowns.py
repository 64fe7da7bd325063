# SPDX-License-Identifier: Apache-2.0
"""Crowns: closed surfaces around their lobes, with leaves where they are wanted."""

from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test.scene.test_mesh import area, volume

from rocsafe_scene.parts import crowns
from rocsafe_scene.parts.crowns import Blob, Crown, CrownOptions, scattered, skin, smooth_normals

SIZES = st.floats(1.0, 4.0)
# A polyhedron of triangles of 0.23 m lies within its ellipsoid; share of the volume.
FACETS = 0.03


def crown(*lobes, size):
    """Return a crown about (0, 0, 5) with lobes (centre, half axes)."""
    return Crown(
        lobes=[Blob(centre=np.array(centre), radii=np.array(radii)) for centre, radii in lobes],
        middle=np.array([0.0, 0.0, 5.0]),
        size=np.array(size),
        leaf=(80, 120, 50),
        variety=0.4,
    )


@pytest.fixture
def plain(monkeypatch):
    """Draw crowns without dents, and not flattened."""
    monkeypatch.setattr(crowns, 'CROWN', CrownOptions(dents=(), flattened=1.0))


@pytest.mark.usefixtures('plain')
@settings(max_examples=15, deadline=None)
@given(SIZES, SIZES, SIZES)
def test_a_single_lobe_is_its_ellipsoid(x, y, z):
    """Each point of the surface is on it, to a step of the search; so is the volume."""
    half = (x, y, z)
    made = skin(crown(((0.0, 0.0, 5.0), half), size=half), np.random.default_rng(1))
    away = (made.points - [0.0, 0.0, 5.0]) / half
    assert np.linalg.norm(away, axis=1) == pytest.approx(1.0, abs=0.04)
    exact = 4.0 / 3.0 * np.pi * x * y * z
    assert volume(made) == pytest.approx(exact, rel=0.12)
    assert volume(made) <= exact * (1.0 + FACETS)


@pytest.mark.parametrize('density', [0.2, 1.0, 3.0])
def test_a_crown_is_closed_and_faces_outwards(density):
    """Every edge has two triangles that run through it in opposite directions: V - E + F = 2."""
    lobes = [((0.0, 0.0, 5.0), (2.0, 2.0, 2.0)), ((1.2, 0.4, 6.0), (1.3, 1.5, 1.1))]
    made = skin(crown(*lobes, size=(2.6, 2.2, 2.3)), np.random.default_rng(2), density)
    edges = Counter()
    for a, b, c in made.triangles.tolist():
        edges.update([(a, b), (b, c), (c, a)])
    assert set(edges.values()) == {1}
    assert all((b, a) in edges for a, b in edges)
    assert len(made.points) - len(edges) // 2 + len(made.triangles) == 2
    assert volume(made) > 0.0


def test_more_density_gives_more_triangles_of_the_same_crown():
    """The number grows with it, the volume hardly changes."""
    one = crown(((0.0, 0.0, 5.0), (2.5, 2.5, 2.5)), size=(2.5, 2.5, 2.5))
    coarse, fine = (skin(one, np.random.default_rng(4), density) for density in (0.3, 1.2))
    assert len(fine.triangles) == pytest.approx(4 * len(coarse.triangles), rel=0.35)
    assert volume(fine) == pytest.approx(volume(coarse), rel=0.1)


@pytest.mark.usefixtures('plain')
def test_normals_of_a_ball_are_its_radii():
    """Averaged over the triangles around each point."""
    made = skin(crown(((0.0, 0.0, 5.0), (2.0,) * 3), size=(2.0,) * 3), np.random.default_rng(1))
    radial = (made.points - [0.0, 0.0, 5.0]) / 2.0
    normals = smooth_normals(made.points, made.triangles)
    assert np.linalg.norm(normals, axis=1) == pytest.approx(1.0)
    assert np.einsum('ij,ij->i', normals, radial).min() > 0.97


@pytest.mark.usefixtures('plain')
def test_leaves_lie_on_the_surface_and_mostly_on_its_sides():
    """Their number follows the density; a square metre of the top gets the stated share.

    The top begins where the normal's third component rises from 0.25 to 0.75, smoothly: a quarter
    of a sphere by area, since bands of equal height have equal areas (Archimedes).
    """
    made = skin(crown(((0.0, 0.0, 5.0), (3.0,) * 3), size=(3.0,) * 3), np.random.default_rng(1))
    density = 40.0
    places, normals, colours = scattered(made, density, np.random.default_rng(5))
    assert np.linalg.norm(places - [0.0, 0.0, 5.0], axis=1) == pytest.approx(3.0, abs=0.15)
    expected = density * area(made) * (1.0 - 0.25 * (1.0 - crowns.CROWN.on_top))
    assert len(places) == pytest.approx(expected, rel=0.01)
    counts = []
    for low in (-0.2, 0.8):
        is_in = (normals[:, 2] > low) & (normals[:, 2] < low + 0.2)
        counts.append(int(is_in.sum()))
    assert counts[1] == pytest.approx(crowns.CROWN.on_top * counts[0], rel=0.35)
    assert (colours > 0.0).all()


def test_the_same_generator_makes_the_same_crown():
    """Byte for byte; another makes other dents."""
    one = crown(((0.0, 0.0, 5.0), (2.0,) * 3), size=(2.0,) * 3)
    first, again, other = (skin(one, np.random.default_rng(seed)) for seed in (7, 7, 8))
    assert (first.points == again.points).all()
    assert (first.colours == again.colours).all()
    assert (first.points != other.points).any()

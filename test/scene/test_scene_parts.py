# SPDX-License-Identifier: Apache-2.0
"""What scenes are made of: sound meshes, the same from the same seed."""

import numpy as np
import pytest

from rocsafe_scene.mesh import shapes
from rocsafe_scene.mesh.mesh import joined
from rocsafe_scene.mesh.surfaces import Surface
from rocsafe_scene.parts.plants import tufts
from rocsafe_scene.parts.thinning import coarser, sparser
from rocsafe_scene.scene.catalogue import MAKERS

COURSE = np.column_stack([np.linspace(0.0, 18.0, 13), np.linspace(0.0, 3.0, 13), np.zeros(13)])
SOLIDS = {
    'box': (shapes.box(2.0, 1.0, 0.5, 0.01), 1.0),
    'cylinder': (shapes.cylinder(0.5, 2.0, 64), np.pi * 0.5),
    'upright cone': (shapes.upright(1.0, 3.0, 64, 0.0), np.pi),
    'ball': (shapes.ball(1.0, 48), 4.0 / 3.0 * np.pi),
    'prism': (shapes.prism([(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)], 3.0), 6.0),
}


def made(name: str, seed: int = 1):
    """Return what the maker called `name` makes."""
    maker, rng = MAKERS[name], np.random.default_rng(seed)
    return maker.make_along(rng, COURSE, {}) if maker.piece_m else maker.make(rng, {})


def corners_of(mesh):
    """Return the corners of all triangles, (m, 3, 3)."""
    return mesh.points[mesh.triangles]


@pytest.mark.slow
@pytest.mark.parametrize('name', MAKERS)
def test_meshes_are_finite_lit_from_outside_and_of_a_sane_size(name):
    """Normals have length one and, but for leaves, agree with the winding of their triangles."""
    mesh = made(name)
    assert np.isfinite(mesh.points).all()
    assert np.allclose(np.linalg.norm(mesh.normals, axis=1), 1.0, atol=1e-6)
    assert 0.1 < np.ptp(mesh.points, axis=0).max() < 40.0
    if not MAKERS[name].is_foliage:
        a, b, c = corners_of(mesh).swapaxes(0, 1)
        across = np.cross(b - a, c - a)
        facing = np.einsum('ij,ij->i', across, mesh.normals[mesh.triangles[:, 0]])
        assert np.count_nonzero(facing < -1e-9) <= 0.01 * len(facing)


@pytest.mark.slow
@pytest.mark.parametrize('name', MAKERS)
def test_the_same_seed_makes_the_same_mesh(name):
    """Nothing comes from anywhere but the generator."""
    assert np.array_equal(made(name).points, made(name).points)


@pytest.mark.parametrize('name', SOLIDS)
def test_solids_enclose_their_volume(name):
    """The volume inside the surface is that of the formula, within the facets' share."""
    mesh, volume = SOLIDS[name]
    a, b, c = corners_of(mesh).swapaxes(0, 1)
    assert np.einsum('ij,ij->i', np.cross(a, b), c).sum() / 6.0 == pytest.approx(volume, rel=0.02)


def test_a_mesh_refuses_corners_it_does_not_have():
    """A triangle that names a corner beyond the last is no mesh."""
    box = shapes.box(1.0, 1.0, 1.0)
    with pytest.raises(ValueError, match='corners outside 0 to 23'):
        type(box)(
            points=box.points, normals=box.normals, places=box.places, colours=box.colours,
            triangles=box.triangles + 1,
        )  # fmt: skip


def test_joining_keeps_every_triangle():
    """The parts' triangles are all there, each over its own corners."""
    one, two = shapes.box(1.0, 1.0, 1.0), shapes.ball(1.0).moved(x=5.0)
    both = joined([one, two])
    assert len(both.triangles) == len(one.triangles) + len(two.triangles)
    assert np.allclose(corners_of(both)[len(one.triangles) :], corners_of(two))


def test_thinned_trees_are_lighter_and_as_large():
    """Each step has a fraction of the triangles, and the crown keeps its size."""
    full, thin, *thinner = coarser(made('tree'))
    assert len(thin.triangles) < 0.45 * len(full.triangles)
    counts = [len(mesh.triangles) for mesh in (thin, *thinner)]
    assert counts == sorted(counts, reverse=True)
    assert np.allclose(np.ptp(thin.points, axis=0), np.ptp(full.points, axis=0), rtol=0.15)


@pytest.mark.slow
@pytest.mark.parametrize('species', ['oak', 'willow'])
def test_the_skin_of_a_crown_is_closed_and_faces_outwards(species):
    """Each edge belongs to two triangles, wound opposite ways; the volume is that of a crown."""
    tree = MAKERS['tree'].make(np.random.default_rng(3), {'species': species})
    is_skin = (tree.colours[:, 3] == Surface.CROWN)[tree.triangles].all(axis=1)
    triangles = tree.triangles[is_skin]
    edges = np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)])
    there, back = ({tuple(edge) for edge in way.tolist()} for way in (edges, edges[:, ::-1]))
    assert len(there) == len(edges)
    assert there == back
    a, b, c = tree.points[triangles].swapaxes(0, 1)
    volume = np.einsum('ij,ij->i', np.cross(a, b), c).sum() / 6.0
    assert 20.0 < volume < 300.0


def test_sparser_grass_is_every_other_tuft():
    """Half the blades, those left where they were."""
    feet = np.column_stack([np.arange(10.0), np.zeros((10, 2))])
    full = tufts(np.random.default_rng(2), feet)
    thin = sparser(full)
    assert 2 * len(thin.triangles) == len(full.triangles)
    assert np.array_equal(thin.points[:30], full.points[:30])
    assert np.array_equal(thin.points[30:60], full.points[60:90])

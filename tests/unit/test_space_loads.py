"""Pressures and tractions on polyhedra: their resultants and moments, in-situ tractions, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.model.changes import with_load_factor
from bsm_mesh.model.loads import point_forces_of
from tests.scenes.faults import fault
from tests.scenes.polyhedra import box, model_in_space, prism, rotation, turned

HEXAGON = [(0.1, 0), (1, 0.2), (1.3, 1), (0.9, 1.7), (0.2, 1.6), (-0.3, 0.8)]
SIDES = ("west", "east", "south", "north")


def resultant(model):
    """Return force and moment of a model's loads about the centroid of its first block."""
    forces = point_forces_of(model.acting_loads, model.blocks)
    arm = forces.point - model.blocks.moments.centroid[0]
    return forces.force.sum(axis=0), np.cross(arm, forces.force).sum(axis=0)


def loaded(load, **more):
    """Return a model of one turned prism with a load on its whole surface."""
    model = model_in_space(turned([prism(HEXAGON, 0.7)], rotation(20, 35)), fixed=(0,), **more)
    return model.replace(blocks=model.blocks.with_boundary("all", lambda x, y, z: x > -9), loads=[load])


def test_a_linear_pressure_on_the_whole_surface_is_buoyancy():
    """By the divergence theorem: minus the gradient times the volume, without moment about the centroid."""
    model = loaded(bsm.Pressure(boundary="all", pressure=(5e4, 1e3, -2e3, -1e4)))
    force, moment = resultant(model)
    assert_allclose(force, model.blocks.moments.volume[0] * np.array([-1e3, 2e3, 1e4]), rtol=1e-12)
    assert_allclose(moment, 0, atol=1e-9)


def test_a_linear_traction_has_its_resultant_and_moment():
    """On a face of 1 m x 1 m at x = 1: components linear in y and z, integrated by hand."""
    model = model_in_space([box((0, 0, 0), (1, 1, 1))], fixed=(0,))
    blocks = model.blocks.with_boundary("east", lambda x, y, z: x > 1 - 1e-9)
    load = bsm.Traction(boundary="east", traction=(6e3, (0, 0, 12e3, 0), (0, 0, 0, 24e3)))
    force, moment = resultant(model.replace(blocks=blocks, loads=[load]))
    assert_allclose(force, [6e3, 6e3, 12e3], rtol=1e-12)
    assert_allclose(moment, [0, -6e3, 3e3], atol=1e-9)  # about the centroid, 0.5 m behind the face
    constant = bsm.Traction(boundary="east", traction=(6e3, -1e3, 2e3))
    force, _ = resultant(with_load_factor(model.replace(blocks=blocks, loads=[constant]), 3.0, number=1))
    assert_allclose(force, [18e3, -3e3, 6e3], rtol=1e-12)


@pytest.mark.parametrize(("trend", "k0", "across"), [(0.0, 0.5, 0.5), (30.0, 0.5, 1.2)])
def test_in_situ_tractions_carry_the_ground(trend, k0, across):
    """On the whole surface of a block they carry its weight; round a cube of ground nothing moves."""
    ground = bsm.InSitu(surface=10.0, k0=k0, k0_across=across, trend=trend)
    model = loaded(bsm.InSituTraction(boundary="all"), in_situ=ground)
    force, moment = resultant(model)
    assert_allclose(force, [0, 0, model.weights[0]], atol=1e-9 * model.weights[0])
    assert_allclose(moment, 0, atol=1e-9 * model.weights[0])

    cubes = [box((x, y, z), (x + 1, y + 1, z + 1)) for x in range(2) for y in range(2) for z in range(2)]
    model = model_in_space(cubes)
    blocks = model.blocks.with_boundary("top", lambda x, y, z: z > 2 - 1e-9)
    blocks = blocks.with_boundary("bottom", lambda x, y, z: z < 1e-9)
    for name, axis, at in (("west", 0, 0), ("east", 0, 2), ("south", 1, 0), ("north", 1, 2)):
        blocks = blocks.with_boundary(name, lambda *place, axis=axis, at=at: np.abs(place[axis] - at) < 1e-9)
    loads = [bsm.InSituTraction(boundary=name) for name in ("top", *SIDES)]
    results = bsm.run(
        model.replace(blocks=blocks, in_situ=ground, loads=loads, supports=[bsm.Fixed(boundary="bottom")])
    )
    assert results.status == "stable"
    assert np.abs(results.stages[0].displacement).max() < 1e-12


@pytest.mark.parametrize(("pressure", "force"), [(1e4, 1e4), ((1e4, 0, 0, 2e3), 11e3)])
def test_a_face_that_a_stage_lays_bare_is_loaded_on_the_side_that_stays(pressure, force):
    """The same pressure pushes both blocks away from the face between them."""
    model = model_in_space([box((x, 0, 0), (x + 1, 1, 1)) for x in range(2)])
    face = np.flatnonzero(model.blocks.face_cells[:, 1] >= 0)
    blocks = replace(model.blocks, boundaries={"wall": face.astype(np.int32)})
    found = point_forces_of([bsm.Pressure(boundary="wall", pressure=pressure)], blocks)
    assert_allclose(np.bincount(found.block, found.force[:, 0]), [-force, force], rtol=1e-12)


@pytest.mark.parametrize(
    ("load", "words"),
    [
        (bsm.Traction(boundary="east", traction=(1e3, 0)), "traction has 2 components; it needs three"),
        (
            bsm.Pressure(boundary="east", pressure=(1e3, 0, 1e3)),
            r"give each component as one number or as [c, a_x, a_y, a_z]",
        ),
        (bsm.InSituTraction(boundary="east"), "in_situ = true needs the field"),
        (bsm.InSituTraction(boundary="est"), "there is no boundary 'est'; did you mean 'east'?"),
    ],
)
def test_loads_that_do_not_fit_are_refused(load, words):
    model = model_in_space([box((0, 0, 0), (1, 1, 1))], fixed=(0,))
    blocks = model.blocks.with_boundary("east", lambda x, y, z: x > 1 - 1e-9)
    with fault(words):
        model.replace(blocks=blocks, loads=[load])


def test_in_the_plane_loads_of_space_are_refused():
    blocks = bsm.Blocks.from_polygons([[(0, 0), (1, 0), (1, 1), (0, 1)]], rock="rock")
    blocks = blocks.with_boundary("top", lambda x, y: y > 1 - 1e-9)
    for load, words in (
        (bsm.Traction(boundary="top", traction=(0, 0, 1e3)), "traction has 3 components; it needs two"),
        (bsm.Pressure(boundary="top", pressure=(1e3, 0, 0, 1e3)), "as one number or as [c, a_x, a_y]"),
    ):
        with fault(words):
            bsm.Model(blocks=blocks, rocks=[bsm.Rock("rock", unit_weight=25e3)], loads=[load])

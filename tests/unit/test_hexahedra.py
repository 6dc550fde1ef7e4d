"""Domes and vaults of hexahedral blocks: volumes, groups, the least thickness of an arch, models on them."""

import re

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.converters.three_d import read_polyhedra
from bsm_mesh.geometries import GeometryError, barrel_vault, dome
from bsm_mesh.three_d.limit.analysis import LimitAnalysis3D, weights
from bsm_mesh.three_d.limit.points import LimitPoints
from bsm_mesh.three_d.limit.strength import ConeStrength
from tests.scenes.small_case import Case

ROUNDING = 1e-9
SPACE = """
dimensions = 3
[mesh]
{mesh}
[rock.stone]
unit_weight = "25 kN/m^3"
[joint.joint]
normal_stiffness = "10 GPa/m"
shear_stiffness = "5 GPa/m"
law = "mohr_coulomb"
friction = 40
[[support]]
boundary = "base"
fix = "all"
"""


def first_moment(outline):
    """Return the integral of the distance from the axis over a polygon (k, 2) of distance and height [m3]."""
    r, z = outline.T
    following = np.roll(outline, -1, axis=0)
    return abs((r * following[:, 1] - following[:, 0] * z) @ (r + following[:, 0])) / 6


def test_a_dome_has_the_volume_of_its_profile_turned_in_chords(tmp_path):
    """A level section of a sector between two distances is a trapezium: half their squares' difference times sin."""
    sectors, courses = 7, 5
    blocks = read_polyhedra(
        dome.build(tmp_path / "dome.msh", radius=3.0, thickness=0.4, sectors=sectors, courses=courses, eye=10.0),
        blocks="elements",
    )
    assert blocks.count == sectors * (courses + 1)
    assert blocks.contact_polygons.count == sectors * (courses + 1) + sectors * courses
    assert (blocks.contact_polygons.joint == 0).all()
    assert blocks.boundary_blocks("base").tolist() == list(range(sectors * courses, sectors * (courses + 1)))
    fall = np.linspace(np.radians(10), np.pi / 2, courses + 1)
    ray = np.stack([np.sin(fall), np.cos(fall)], axis=1)
    volume = sectors * np.sin(2 * np.pi / sectors) * first_moment(np.concatenate([3.2 * ray, 2.8 * ray[::-1]]))
    assert_allclose(blocks.moments.volume[: sectors * courses].sum(), volume, rtol=ROUNDING)


def test_a_vault_has_the_volume_of_its_stones(tmp_path):
    blocks = read_polyhedra(barrel_vault.build(tmp_path / "vault.msh", stones=9, rings=2), blocks="elements")
    stone = (5.4**2 - 4.6**2) / 2 * np.sin(np.radians(20)) * 3
    assert_allclose(blocks.moments.volume, np.full(22, stone), rtol=ROUNDING)
    assert blocks.boundary_blocks("right").tolist() == [0, 11]
    assert blocks.boundary_blocks("left").tolist() == [10, 21]


@pytest.mark.parametrize(("thickness", "stands"), [(0.1080, True), (0.1065, False)])
def test_an_arch_of_one_ring_needs_the_thickness_of_milankovitch(tmp_path, thickness, stands):
    """.10748 of the radius with many stones: friction forbids sliding."""
    path = barrel_vault.build(tmp_path / "arch.msh", radius=1.0, thickness=thickness, stones=60, rings=1, length=1.0)
    blocks = read_polyhedra(path, blocks="elements")
    held = np.isin(np.arange(blocks.count), blocks.boundary_blocks("left", "right"))
    analysis = LimitAnalysis3D(blocks.moments, LimitPoints.of(blocks.contact_polygons), held)
    strength = ConeStrength.coulomb(analysis.points.area, 50.0)
    assert analysis.analyse(weights(blocks.moments, np.ones(blocks.count)), strength).admissible == stands


@pytest.mark.parametrize(
    ("build", "given", "match"),
    [
        (dome.build, {"thickness": 10.0}, "thickness = 10.0 m is not less than twice radius = 5.0 m; give less"),
        (dome.build, {"eye": 0.0}, "eye = 0.0 does not lie from 0.01 to less than 85 degrees"),
        (dome.build, {"sectors": 2}, "sectors = 2 is not a whole number of at least 3"),
        (dome.build, {"sectors": 10**5, "courses": 10**5}, "make more than 500000 blocks; give fewer"),
        (barrel_vault.build, {"opening": 269.0, "stones": 3}, "opening = 269.0 degrees of 3 stones leaves no room"),
        (barrel_vault.build, {"length": 0}, "length = 0 is not a positive number"),
    ],
)
def test_sizes_that_do_not_fit_are_refused(tmp_path, build, given, match):
    with pytest.raises(GeometryError, match=re.escape(match)):
        build(tmp_path / "x.msh", **given)
    assert not (tmp_path / "x.msh").exists()


def test_a_model_file_builds_its_geometry(case: Case):
    given = 'geometry = "dome"\nblocks = "elements"\nparameters = {sectors = 5, courses = 3}\n'
    case.write("dome.toml", SPACE.format(mesh=given))
    assert bsm.load(case.folder / "dome.toml").blocks.count == 20


def test_a_script_builds_the_mesh_of_three_dimensions(case: Case):
    case.write(
        "own.py", "from bsm_mesh.geometries import dome\n\ndef build(path, n=4):\n    dome.build(path, sectors=n)\n"
    )
    case.write("dome.toml", SPACE.format(mesh='geometry = "own.py"\nblocks = "elements"\nparameters = {n = 3}\n'))
    assert bsm.load(case.folder / "dome.toml").blocks.count == 33
    case.refuses("run", "dome.toml", "--no-scripts", says=['[mesh] geometry = "own.py" is a script'])


@pytest.mark.parametrize(
    ("mesh", "match"),
    [
        (
            'geometry = "dome"\nparameters = {sector = 5}',
            "dome: there is no parameter 'sector'; did you mean 'sectors'?",
        ),
        ('geometry = "doom"', "there is no case 'doom'; did you mean 'dome'?"),
        ('geometry = "circular_tunnel"', "holds no volume elements"),
        ('file = "x.msh"\nparameters = {sectors = 5}', "[mesh.parameters] belong to a geometry; [mesh] has a file"),
        ('file = "x.py"', '[mesh] file is a script; write geometry = "x.py"'),
    ],
)
def test_geometries_that_do_not_fit_are_refused(case: Case, mesh, match):
    case.write("dome.toml", SPACE.format(mesh=mesh))
    case.refuses("run", "dome.toml", says=[match])

"""Key blocks: block theory against an optimiser, wedges by Hoek & Bray, roof blocks, water, support, a tunnel.

The direction in which a block without friction moves is the load's projection on the cone of possible movements
(Goodman & Shi 1985), which non-negative least squares find by themselves.
"""

import csv

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import linprog, nnls

import bsm_mesh as bsm
from bsm_mesh.geometries import three_d
from bsm_mesh.three_d.key_blocks.modes import FALLS, ONE, STAYS, TWO, movements, removable
from tests.scenes.rock_3d import WEDGES, tunnel_rock, wedge_factor, wedge_rock
from tests.unit.test_polyhedra import rotation

ROUNDING = 1e-9  # of factors
ROCK = [bsm.Rock("rock", unit_weight=26e3)]


def joint(name, friction=30.0, cohesion=0.0):
    law = bsm.MohrCoulomb(friction=friction, cohesion=cohesion)
    return bsm.Joint(name, normal_stiffness=1e9, shear_stiffness=1e9, law=law)


def random_planes(count, planes, seed):
    """Return unit normals, some rows of fewer planes, about a direction in which most of them open."""
    generator = np.random.default_rng(seed)
    normals = generator.normal(size=(count, planes, 3)) + 0.6 * generator.normal(size=(count, 1, 3))
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    normals[np.arange(planes) >= generator.integers(1, planes + 1, count)[:, None]] = 0
    return normals


@pytest.mark.parametrize("planes", [2, 3, 5, 8])
def test_movements_are_projections_on_the_cone_of_what_is_possible(planes):
    normals = random_planes(200, planes, planes)
    load = np.random.default_rng(9).normal(size=(200, 3))
    found = movements(normals, load)
    assert len(set(found.mode.tolist())) > 2
    for n, w, mode, along, force in zip(normals, load, found.mode, found.direction, found.normal_force, strict=True):
        reaction, length = nnls(n.T, -w)
        left = w + n.T @ reaction
        if mode == STAYS:
            assert length < 1e-9
            continue
        assert_allclose(along, left / np.linalg.norm(left), atol=1e-9)
        assert mode == {0: FALLS, 1: ONE, 2: TWO}[int((reaction > 1e-12).sum())]
        assert_allclose(np.sort(force[force > 0]), np.sort(reaction[reaction > 1e-12]), rtol=1e-9)


@pytest.mark.parametrize("planes", [3, 4, 6, pytest.param(9, marks=pytest.mark.heavy)])
def test_removable_blocks_are_those_whose_cone_holds_a_direction(planes):
    normals = random_planes(150, planes, planes)
    for n, can in zip(normals, removable(normals), strict=True):
        n = n[np.abs(n).max(axis=1) > 0]
        found = linprog(-n.sum(axis=0), A_ub=-n, b_ub=np.zeros(len(n)), bounds=[(-1, 1)] * 3)
        assert can == (-found.fun > 1e-7)


def test_a_block_between_parallel_planes_can_leave_along_them():
    normals = np.array([[(0, 0, 1), (0, 0, -1), (0, 0, 0)], [(0, 0, 1), (0, 0, -1), (1, 0, 0)], [(0, 0, 0)] * 3], float)
    turn = rotation(7).T
    assert removable(normals).all()
    assert removable(normals @ turn).all()
    closed = np.array([[(0, 0, 1), (0, 0, -1), (1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0)]], float)
    assert not removable(closed).any()
    assert not removable(closed @ turn).any()


@pytest.mark.parametrize("name", WEDGES)
def test_a_wedge_in_a_slope_has_the_factor_of_hoek_and_bray(name):
    first, second, face, top, height, friction, cohesion, unit_weight = WEDGES[name]
    blocks, wedge, volume, areas = wedge_rock(first, second, face, top, height)
    found = bsm.key_blocks(
        blocks,
        rocks=[bsm.Rock("rock", unit_weight=unit_weight)],
        joints=[joint(n, f, c) for n, f, c in zip("AB", friction, cohesion, strict=True)],
        free=["slope"],
    )
    row = np.flatnonzero(found.block == wedge)[0]
    factor = wedge_factor(first, second, volume, areas, unit_weight, friction, cohesion)
    assert found.modes[row] == "slides on two planes"
    assert_allclose(found.factor[row], factor, rtol=ROUNDING)
    assert_allclose(found.weight[row], volume * unit_weight, rtol=ROUNDING)
    assert sorted(found.joints[row].tolist()) == [0, 1]
    assert found.held.sum() == 3
    assert not found.removable[found.held].any()
    assert {found.modes[row] for row in np.flatnonzero(found.held)} == {"not judged"}


def test_wyllie_and_mahs_chart():
    """Their example of planes 40/165 and 70/285 with 35 and 20 degrees: 1.30."""
    first, second, face, top, height, friction, cohesion, unit_weight = WEDGES["Wyllie and Mah's chart"]
    _, _, volume, areas = wedge_rock(first, second, face, top, height)
    assert wedge_factor(first, second, volume, areas, unit_weight, friction, cohesion) == pytest.approx(1.30, abs=0.005)


def slab(dip, **others):
    """Return the key blocks of a cube on a plane of a dip to the east, the other sides free."""
    corners = np.array([(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))], float)
    faces = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    a = np.radians(dip)
    turn = np.array([[np.cos(a), 0, np.sin(a)], [0, 1, 0], [-np.sin(a), 0, np.cos(a)]])
    solids = [(np.add(corners, (0, 0, z)) @ turn.T, faces) for z in (-1, 0)]
    blocks = bsm.Polyhedra.from_solids(solids, rock="rock", joint="J1")
    outer = [f for f in blocks.outer_faces if blocks.face_blocks[f, 0] == 1]
    blocks = blocks.with_boundary("slope", lambda x, y, z: np.ones_like(x, dtype=bool))
    held = [f for f in blocks.outer_faces if f not in outer]
    blocks = bsm.Polyhedra(
        **{name: getattr(blocks, name) for name in blocks.__dataclass_fields__}
        | {"boundaries": {"slope": outer, "rock": held}}
    )
    found = bsm.key_blocks(blocks, rocks=ROCK, free=["slope"], **others)
    assert found.block.tolist() == [1]
    return found


@pytest.mark.heavy
def test_a_cube_on_a_plane():
    a, W = np.radians(40), 26e3
    slope = np.tan(np.radians(30))
    found = slab(40, joints=[joint("J1", 30, 5e3)])
    assert found.modes == ("slides on one plane",)
    assert_allclose(found.direction[0], (np.cos(a), 0, -np.sin(a)), atol=ROUNDING)
    assert_allclose(found.factor, (W * np.cos(a) * slope + 5e3) / (W * np.sin(a)), rtol=ROUNDING)
    wet = slab(40, joints=[joint("J1", 30, 5e3)], joint_pressure={"J1": 8e3})
    assert_allclose(wet.factor, ((W * np.cos(a) - 8e3) * slope + 5e3) / (W * np.sin(a)), rtol=ROUNDING)
    lifted = slab(40, joints=[joint("J1", 30, 5e3)], joint_pressure={"J1": 30e3})
    assert lifted.modes == ("falls",)
    shaken = slab(40, joints=[joint("J1", 30)], gravity=(0.2, 0, -1))
    press, pull = np.cos(a) - 0.2 * np.sin(a), np.sin(a) + 0.2 * np.cos(a)
    assert_allclose(shaken.factor, press * slope / pull, rtol=ROUNDING)


def test_faces_in_one_plane_bear_together():
    """A cube on two blocks side by side, gravity turned by 40 degrees: both faces carry cohesion."""
    rock = three_d.RockMass(
        box=((0, 0, -1), (1, 1, 1)),
        joints=[
            three_d.JointPlane(name="J1", dip=0, dip_direction=0, point=(0, 0, 0)),
            three_d.JointPlane(name="J1", dip=90, dip_direction=0, point=(0.5, 0.3, -0.5), radius=0.4),
        ],
    )
    blocks = bsm.Polyhedra.from_cells(three_d.cut_cells(rock))
    a, W = np.radians(40), 26e3
    found = bsm.key_blocks(
        blocks,
        rocks=ROCK,
        joints=[joint("J1", 30, 5e3)],
        free=["top", "west", "east", "south", "north"],
        gravity=(np.sin(a), 0, -np.cos(a)),
    )
    (row,) = np.flatnonzero(found.removable)
    assert len(blocks.contact_polygons.of(int(found.block[row]))) == 2
    assert_allclose(found.factor[row], (W * np.cos(a) * np.tan(np.radians(30)) + 5e3) / (W * np.sin(a)), rtol=ROUNDING)


def test_a_model_has_all_that_is_asked_for():
    blocks, given = roof(), {"excavated": ["cavern"], "free": ["south", "north"]}
    held = bsm.Fixed(blocks=tuple(blocks.boundary_blocks("top", "east", "west").tolist()))
    model = bsm.Model(blocks=blocks, rocks=ROCK, joints=[joint("J1")], supports=[held])
    by_model, by_parts = (
        bsm.key_blocks(model, **given),
        bsm.key_blocks(blocks, rocks=ROCK, joints=[joint("J1")], **given),
    )
    assert by_model.modes == by_parts.modes
    assert_allclose(by_model.factor, by_parts.factor)
    plane = bsm.Blocks.from_polygons([[(0, 0), (1, 0), (1, 1), (0, 1)]], rock="rock")
    with pytest.raises(bsm.ModelError, match=r"the blocks must be bsm.Polyhedra\(...\)"):
        bsm.key_blocks(bsm.Model(blocks=plane, rocks=ROCK), free=["top"])


@pytest.mark.heavy
def test_excavations_are_open_unless_others_are_named():
    given = {"rocks": ROCK, "joints": [joint("J1")], "free": ["south", "north"]}
    assert_allclose(
        bsm.key_blocks(roof(), **given).factor, bsm.key_blocks(roof(), excavated=["cavern"], **given).factor
    )
    shut = bsm.key_blocks(roof(), excavated=[], **given)
    assert "falls" not in shut.modes


def test_other_laws_have_their_own_strength():
    law = bsm.BartonBandis(jrc=8, jcs=50e6, residual_friction=25)
    found = slab(40, joints=[bsm.Joint("J1", normal_stiffness=1e9, shear_stiffness=1e9, law=law)])
    pressure = 26e3 * np.cos(np.radians(40))
    strength = law.respond(np.array([pressure]), np.zeros(1), np.ones(1), np.array([False])).strength[0]
    assert_allclose(found.factor, strength / (26e3 * np.sin(np.radians(40))), rtol=ROUNDING)
    whole = slab(40, joints=[bsm.Joint("J1", normal_stiffness=1e9, shear_stiffness=1e9)])
    assert np.isinf(whole.factor).all()


def roof():
    """Return a pyramid of four planes of 60 degrees over a level roof, 2 m wide: height tan 60."""
    joints = [
        three_d.JointPlane(name="J1", dip=60, dip_direction=d, point=(np.sin(np.radians(d)), np.cos(np.radians(d)), 2))
        for d in (0, 90, 180, 270)
    ]
    body = three_d.prism([(-5, 0), (5, 0), (5, 2), (-5, 2)])
    rock = three_d.RockMass(
        box=((-6, -6, -1), (6, 6, 6)), joints=joints, bodies=[three_d.Excavation(body=body, name="cavern")]
    )
    return bsm.Polyhedra.from_cells(three_d.cut_cells(rock))


def test_a_pyramid_in_a_roof_falls_and_its_weight_is_borne_by_its_foot():
    blocks = roof()
    kept = bsm.key_blocks(blocks, rocks=ROCK, joints=[joint("J1")], excavated=["cavern"], free=["south", "north"])
    row = kept.modes.index("falls")
    height = np.sqrt(3)
    assert_allclose(kept.volume[row], 4 * height / 3, rtol=ROUNDING)
    assert_allclose(kept.apex[row], height, rtol=ROUNDING)
    assert_allclose(kept.trace[row], np.sqrt(8), rtol=ROUNDING)
    assert_allclose(kept.area[row], 4, rtol=ROUNDING)
    assert_allclose(kept.support[row], kept.weight[row] / 4, rtol=1e-6)
    assert kept.direction[row].tolist() == [0, 0, -1]
    assert kept.round[row] == 1


def test_a_support_gives_the_factor_that_is_asked_for():
    first, second, face, top, height, friction, _, unit_weight = WEDGES["symmetric"]
    blocks, wedge, volume, _ = wedge_rock(first, second, face, top, height)
    given = {"rocks": ROCK, "joints": [joint("A", friction[0]), joint("B", friction[1])], "free": ["slope"]}
    found = bsm.key_blocks(blocks, **given, required=1.5)
    row = np.flatnonzero(found.block == wedge)[0]
    pressure, outward = found.support[row], np.zeros(3)
    for f in blocks.boundary_faces("slope"):
        if blocks.face_blocks[f, 0] == wedge:
            a, b, c = blocks.polygon(f)[:3]
            outward += np.cross(b - a, c - a) / 2
    polygons = blocks.contact_polygons
    n1, n2 = (polygons.normal[k] * (1 if polygons.block_a[k] == wedge else -1) for k in polygons.of(wedge))
    load = np.array([0, 0, -volume * unit_weight]) - pressure * outward
    line = np.cross(n1, n2) / np.linalg.norm(np.cross(n1, n2))
    line *= np.sign(line @ load)
    on1, on2, pull = np.linalg.solve(np.array([n1, n2, -line]).T, -load)
    assert (on1 + on2) * np.tan(np.radians(30)) / pull == pytest.approx(1.5, rel=1e-6)
    assert found.round[row] == 1


CAPACITY = 30e3  # N of a bolt; the pyramid weighs 60 kN
BAR = {"diameter": 0.02, "yield_strength": CAPACITY / (np.pi * 0.02**2 / 4)}


CAVERN = {"rocks": ROCK, "joints": [joint("J1")], "excavated": ["cavern"], "free": ["south", "north"]}
INSIDE = np.sqrt(3) / 2  # m of 2 m of the bolt are in the pyramid, the others in rock above


@pytest.mark.parametrize(
    ("keys", "pull"),
    [
        ({"kind": "end_anchored"}, CAPACITY),
        ({"kind": "end_anchored", "anchor_capacity": 20e3}, 20e3),
        ({"bond_strength": 50e3}, CAPACITY),
        ({"bond_strength": 12e3}, 12e3 * INSIDE),
        ({"bond_strength": 12e3, "plate": 2e3}, 12e3 * INSIDE + 2e3),
        ({"bond_strength": 12e3, "plate": 50e3}, 12e3 * (2 - INSIDE)),
    ],
)
def test_bolts_take_their_pull_off_the_weight_of_a_pyramid(keys, pull):
    """The least of yield, anchorage, bond and plate in the pyramid, and bond beyond it."""
    bolts = [bsm.Bolt(start=(0.5, 0.1, 2), end=(0.5, 0.1, 4), **BAR, **keys)]
    found = bsm.key_blocks(roof(), **CAVERN, bolts=bolts)
    row = found.modes.index("falls")
    assert_allclose(found.pull[row], pull, rtol=1e-6)
    assert_allclose(found.support[row] * found.area[row], found.weight[row], rtol=1e-6)
    assert_allclose(found.bolted_support[row] * found.area[row], found.weight[row] - pull, rtol=1e-6)
    assert found.round[row] == 1
    held = bsm.key_blocks(roof(), **CAVERN, bolts=bolts * 7)
    assert (held.round[row], held.bolted_support[row]) == (0, 0)


def test_bolts_of_any_strength_are_refused():
    bolt = bsm.Bolt(start=(0.5, 0.1, 2), end=(0.5, 0.1, 4), diameter=0.02)
    with pytest.raises(bsm.ModelError, match="carries any force; give it a yield_strength"):
        bsm.key_blocks(roof(), **CAVERN, bolts=[bolt])


def test_bolts_in_a_wedge_have_the_factor_of_limit_equilibrium():
    first, second, face, top, height, friction, _, weight = WEDGES["symmetric"]
    blocks, wedge, volume, areas = wedge_rock(first, second, face, top, height)
    head = blocks.moments.centroid[wedge]
    turn = np.radians(face[1])
    into = -np.array([np.sin(turn), np.cos(turn), 0.2]) / np.sqrt(1.04)
    pull = 0.2 * weight * volume
    bolt = bsm.Bolt(
        start=tuple(head),
        end=tuple(head + 2.4 * blocks.moments.size[wedge] * into),
        kind="end_anchored",
        diameter=0.4,
        yield_strength=pull / (np.pi * 0.4**2 / 4),
    )
    rocks = [bsm.Rock("rock", unit_weight=weight)]
    joints = [joint("A", friction[0]), joint("B", friction[1])]
    found = bsm.key_blocks(blocks, rocks=rocks, joints=joints, free=["slope"], bolts=[bolt])
    row = np.flatnonzero(found.block == wedge)[0]
    exact = wedge_factor(first, second, volume, areas, weight, friction, (0, 0), pull * into)
    assert_allclose(found.bolted_factor[row], exact, rtol=1e-9)
    assert_allclose(found.factor[row], wedge_factor(first, second, volume, areas, weight, friction, (0, 0)), rtol=1e-9)


@pytest.mark.heavy
def test_a_tunnel_in_three_sets():
    """Counts and modes by a prototype that solved a linear program for every block; three slide at exactly 1."""
    blocks = bsm.Polyhedra.from_cells(three_d.cut_cells(tunnel_rock()))
    found = bsm.key_blocks(blocks, rocks=ROCK, joints=[joint(f"J{k}") for k in (1, 2, 3)], free=["tunnel"])
    assert (~found.held).sum() == 105
    assert found.removable.sum() == 42
    assert found.modes.count("falls") == 3
    slides = found.factor[(found.factor > 0) & (found.factor < 1 + ROUNDING)]
    assert_allclose(np.sort(slides), [np.tan(np.radians(30)) / np.tan(np.radians(75))] * 4 + [1, 1, 1], rtol=ROUNDING)
    assert found.unstable.sum() == 7
    assert (found.sliver & found.unstable).sum() == 2
    opened = bsm.key_blocks(blocks, rocks=ROCK, joints=[joint(f"J{k}") for k in (1, 2, 3)], free=["tunnel"], rounds=9)
    assert (opened.round == 1).sum() == 7
    assert opened.round.max() > 1
    assert set(opened.block[opened.round == 1]) == set(found.block[found.unstable])


@pytest.mark.heavy
@pytest.mark.parametrize("shift", [(4.5e6, 5.2e6, 300.0), (-17.0, 40.0, 1e3)])
def test_where_the_rock_lies_does_not_matter(shift):
    """In map coordinates faces are known to a nanometre only."""
    given = {"rocks": ROCK, "joints": [joint(f"J{k}") for k in (1, 2, 3)], "free": ["tunnel"]}
    here, there = (
        bsm.key_blocks(bsm.Polyhedra.from_cells(three_d.cut_cells(tunnel_rock(3.0, shift=by))), **given)
        for by in ((0.0, 0.0, 0.0), shift)
    )
    assert here.modes == there.modes
    assert_allclose(there.factor, here.factor, rtol=1e-6)
    assert_allclose(there.volume, here.volume, rtol=1e-6, atol=1e-9)


def test_tables_have_a_row_a_block(tmp_path):
    found = bsm.key_blocks(roof(), rocks=ROCK, joints=[joint("J1")], excavated=["cavern"], free=["south", "north"])
    with found.save(tmp_path / "key_blocks.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == found.count
    falling = next(row for row in rows if row["mode"] == "falls")
    assert float(falling["weight [N]"]) == pytest.approx(4 * np.sqrt(3) / 3 * 26e3)
    found.save(tmp_path / "key_blocks.parquet")
    with pytest.raises(bsm.ModelError, match=r"a table ends in .csv or .parquet"):
        found.save(tmp_path / "key_blocks.xls")
    assert "1 fall" in repr(found)


def test_the_table_goes_to_pandas():
    pytest.importorskip("pandas")
    found = bsm.key_blocks(roof(), rocks=ROCK, joints=[joint("J1")], excavated=["cavern"], free=["south", "north"])
    frame = found.to_pandas()
    assert len(frame) == found.count
    assert frame[frame["mode"] == "falls"].weight.sum() == pytest.approx(4 * np.sqrt(3) / 3 * 26e3)
    assert frame.attrs["units"]["support_pressure"] == "Pa"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"free": ["rof"]}, "there is no boundary 'rof'"),
        ({"excavated": ["tunnel"]}, "there is no excavation 'tunnel'"),
        ({"joints": []}, "joint 'J1' is not defined"),
        ({"rocks": []}, "rock 'rock' is not defined"),
        ({"joint_pressure": {"J2": 1.0}}, "there is no joint 'J2'"),
        ({"joint_pressure": {"J1": -1.0}}, "must be a number of at least 0 Pa"),
        ({"gravity": (0, -1)}, "must be three numbers"),
        ({"required": 0}, "must be a number above 0"),
        ({"rounds": 0}, "must be a whole number of at least 1"),
        ({"free": [], "excavated": []}, "no block has a free face"),
    ],
)
def test_bad_input_is_named(change, message):
    given = {"rocks": ROCK, "joints": [joint("J1")], "excavated": ["cavern"], "free": ["south"]}
    with pytest.raises(bsm.ModelError, match=message):
        bsm.key_blocks(roof(), **{**given, **change})

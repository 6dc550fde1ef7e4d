"""The network of a model's joints: faces cut by drains, wells and grout; T-junctions; blocks that are taken away."""

import numpy as np
import pytest

import bsm_mesh as bsm
from bsm_mesh.flow.boundaries import boundaries_of
from bsm_mesh.flow.joint_network import joint_network
from bsm_mesh.flow.pressures import wet_pieces
from bsm_mesh.flow.steady import solve_steady
from tests.scenes.flow_models import bricks
from tests.scenes.flow_networks import conditions, conductance, network

LINEAR = bsm.Options(scheme="linear")
HEADS = {"left": 2.5, "right": 1.0}


def flow_of(model):
    return bsm.run(model, LINEAR).stages[-1].flow


def test_joints_of_a_wall_are_its_pieces():
    joints = joint_network(bricks(columns=4, rows=3))
    assert len(joints.network.first) == 4 * 2 + 3 * 3
    assert joints.network.length.sum() == pytest.approx(2.0 * 8 + 1.0 * 9)


def test_a_drain_cuts_what_it_crosses_and_takes_nodes_that_it_meets():
    drains = [
        bsm.Drain(start=(3, 0.2), end=(3, 2.7)),
        bsm.Drain(start=(0, 1), end=(8, 1)),
        bsm.Drain(start=(4, 0), end=(4, 3)),
    ]
    joints = joint_network(bricks(), drains)
    point = joints.network.point
    assert sorted(map(tuple, point[joints.on_drain[0]])) == [(3, 1), (3, 2)]
    assert sorted(map(tuple, point[joints.on_drain[1]])) == [(0, 1), (2, 1), (3, 1), (4, 1), (6, 1), (8, 1)]
    assert sorted(map(tuple, point[joints.on_drain[2]])) == [(4, 0), (4, 1), (4, 2), (4, 3)]
    assert joints.network.length.sum() == pytest.approx(25)
    assert (joints.network.length > 0.5).all()


def test_grout_cuts_joints_at_its_outline_and_a_well_where_it_stands():
    region = bsm.Grout(polygon=((0.5, 0.5), (2.5, 0.5), (2.5, 1.5), (0.5, 1.5)))
    joints = joint_network(bricks(), (), [bsm.Well(point=(6.7, 2.1), discharge=1e-6)], [region])
    assert joints.network.point[joints.at_well[0]].tolist() == pytest.approx([6.7, 2])
    assert joints.network.length[joints.in_grout[0]].sum() == pytest.approx(2.0 + 1.0)


def test_a_corner_on_an_edge_is_a_node():
    """A wall in bond: the joint below is cut where the upright joint above ends."""
    blocks = bsm.Blocks.from_polygons(
        [[(0, 0), (4, 0), (4, 1), (0, 1)], [(0, 1), (1, 1), (1, 2), (0, 2)], [(1, 1), (4, 1), (4, 2), (1, 2)]], rock="r"
    )
    joint = bsm.Joint("J", 1e9, 1e9, aperture=1e-3, residual_aperture=1e-4)
    model = bsm.Model(blocks=blocks, rocks=[bsm.Rock("r", unit_weight=0)], joints=[joint], default_joint="J")
    joints = joint_network(model)
    assert sorted(map(tuple, joints.network.point)) == [(0, 1), (1, 1), (1, 2), (4, 1)]
    assert len(joints.network.first) == 3


def test_rock_without_a_joint_is_tight():
    blocks = bsm.Blocks.from_polygons([[(0, 0), (1, 0), (1, 1), (0, 1)], [(1, 0), (2, 0), (2, 1), (1, 1)]], rock="r")
    model = bsm.Model(blocks=blocks, rocks=[bsm.Rock("r", unit_weight=0, young=1e9, poisson=0.2)])
    with pytest.raises(bsm.ModelError, match="no face has a joint, and rock is tight"):
        joint_network(model)


def test_an_excavation_drains_the_joints_that_it_lays_bare():
    stage = bsm.Stage(name="adit", excavate=[5])
    model = bricks(flow=bsm.Flow(head=HEADS, coupling="one_way"), stages=[stage])
    before, after = (stage.flow for stage in bsm.run(model, LINEAR).stages)
    assert "new faces" not in before.places
    assert after.leaving[after.places.index("new faces")] > 0
    assert len(after.first) == len(before.first) - 4
    bared = np.isin(np.arange(len(after.point)), np.flatnonzero(after.place == after.places.index("new faces")))
    assert {(2.0, 1.0), (4.0, 1.0)} <= set(map(tuple, after.point[bared]))
    assert (after.head[bared] == after.point[bared, 1]).all()


def test_grout_keeps_water_and_a_drain_takes_it():
    curtain = bsm.Grout(polygon=((2.5, -1), (3.5, -1), (3.5, 4), (2.5, 4)), aperture=0.05e-3)
    drain = bsm.Drain(start=(5, 0.1), end=(5, 2.9))
    plain = flow_of(bricks(flow=bsm.Flow(head=HEADS, coupling="one_way")))
    grouted = flow_of(bricks(flow=bsm.Flow(head=HEADS, coupling="one_way", grout=(curtain,))))
    both = flow_of(bricks(flow=bsm.Flow(head=HEADS, coupling="one_way", grout=(curtain,), drains=(drain,))))
    assert grouted.through < 0.05 * plain.through
    assert both.leaving[both.places.index("drain 1")] > 0
    assert both.imbalance <= 1e-12


def test_sealed_joints_carry_pressure_and_no_flow():
    """What is on both sides of a sealed part is in it too, linearly."""
    curtain = bsm.Grout(polygon=((2.5, -1), (3.5, -1), (3.5, 4), (2.5, 4)))
    flow = flow_of(bricks(flow=bsm.Flow(head={"left": 2.5, "right": 2.2}, coupling="one_way", grout=(curtain,))))
    assert flow.through == 0
    sealed = flow.aperture.max(axis=1) == 0
    assert sealed.sum() == 2
    low = sealed & (flow.point[flow.first, 1] == 1)
    np.testing.assert_allclose(np.sort(flow.wet_pressure[low][0]), 9810 * np.array([1.2, 1.5]), rtol=1e-12)


@pytest.mark.parametrize("conducts", [True, False])
def test_a_joint_above_standing_water_is_wet_to_where_its_pressure_ends(conducts):
    """Full and trickling parts lead the same discharge: (z - p) / z = w (r - p) / r; if sealed, it is stable level."""
    net = network([(0, 10), (0, 5), (0, 0)], [(0, 1), (1, 2)])
    c = conductance(net, [1e-3, 2e-3])
    flow = solve_steady(net, c, conditions(net, head={0: 10.5, 2: 2.0}))
    w = c[0] * 5.5 / (c[1] * 3)
    assert flow.filled[1] == pytest.approx(w, rel=1e-12)
    part, heads = wet_pieces(net, flow, np.array([True, conducts]))
    z = 2 / (1 - w * 3 / 5) if conducts else 2.0
    np.testing.assert_allclose(part[1], [1 - z / 5, 1], rtol=1e-12)
    assert heads[1].tolist() == [0, 2]


@pytest.mark.parametrize("levels", [(("lower", 2.0), ("upper", 2.5)), (("upper", 2.0), ("lower", 2.5))])
def test_where_levels_meet_the_higher_counts(levels):
    blocks = bricks().blocks
    blocks = blocks.with_boundary("lower", lambda x, y: (abs(x) < 1e-9) & (y < 1.001))
    blocks = blocks.with_boundary("upper", lambda x, y: (abs(x) < 1e-9) & (y > 0.999))
    model = bricks().replace(blocks=blocks, flow=bsm.Flow(head=dict(levels) | {"right": 1.0}))
    joints = joint_network(model)
    given = boundaries_of(joints, blocks, model.flow, np.ones(blocks.count, dtype=bool)).conditions
    assert given.head[(joints.network.point == (0, 1)).all(axis=1)].tolist() == [2.5]


def test_an_excavation_drains_joints_that_end_on_a_face_without_one():
    """A joint in the ground ends below rock that is dug away; between the two there is no joint."""
    polygons = [[(0, 0), (2, 0), (2, 1), (0, 1)], [(2, 0), (4, 0), (4, 1), (2, 1)], [(0, 1), (4, 1), (4, 2), (0, 2)]]
    blocks = bsm.Blocks.from_polygons(polygons, rock="r").with_joint("J", lambda x, y: x == 2)
    blocks = blocks.with_boundary("base", lambda x, y: y == 0)
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("r", unit_weight=0, young=1e9, poisson=0.2)],
        joints=[bsm.Joint("J", 1e9, 1e9, aperture=1e-3, residual_aperture=1e-4)],
        supports=[bsm.Fixed(blocks=[0, 1])],
        flow=bsm.Flow(head={"base": 3.0}, coupling="one_way"),
        stages=[bsm.Stage(name="dug", excavate=[2])],
    )
    before, after = (stage.flow for stage in bsm.run(model, LINEAR).stages)
    assert before.through == 0
    assert after.leaving[after.places.index("new faces")] > 0
    assert after.head[after.point[:, 1] == 1] == pytest.approx(1.0)

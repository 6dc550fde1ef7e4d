"""Random joint networks: both engines give the same blocks, and no area and no joint is lost."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from bsm_mesh.converters import NoteKind, read_mesh
from bsm_mesh.geometries import (
    Excavation,
    Exponential,
    Fault,
    JointSet,
    Lognormal,
    Normal,
    Opening,
    Region,
    RockMass,
    cut_blocks,
    write_blocks,
)
from tests.scenes.networks import accounted, areas, areas_within, box, circle, lengths

AREA = 1e-12  # of the region: nothing but rounding

spacings = st.one_of(
    st.floats(1.5, 6.0),
    st.builds(Normal, st.floats(1.5, 5.0), st.floats(0.1, 1.0)),
    st.builds(Lognormal, st.floats(1.5, 5.0), st.floats(0.1, 1.0)),
    st.builds(Exponential, st.floats(2.0, 5.0)),
)
coordinates = st.floats(-12, 12).map(lambda x: round(x, 3))
points = st.tuples(coordinates, coordinates)


@st.composite
def networks(draw: st.DrawFn) -> RockMass:
    sets = [
        JointSet(
            name=f"J{number}",
            dip=draw(st.floats(-90, 90)),
            spacing=draw(spacings),
            scatter=draw(st.sampled_from([0.0, 2.0, 8.0])),
            persistence=draw(st.sampled_from([1.0, 0.8, 0.5])),
            bridge=1.1,
            ends=draw(st.sampled_from(["crossing", "t_ended", "en_echelon"])),
        )
        for number in range(draw(st.integers(0, 3)))
    ]
    lines = draw(st.lists(st.lists(points, min_size=2, max_size=4, unique=True), max_size=3))
    regions: list[Region | Opening | Excavation] = [Region(outline=box(-10, -10, 10, 10), rock="gneiss")]
    if draw(st.booleans()):
        band = [(-10, -6), (10, -3), (10, -2), (-10, -5)]
        regions.append(Region(outline=band, rock="shear_zone", border=draw(st.sampled_from([None, "SZ"]))))
    if draw(st.booleans()):
        regions.append(Excavation(outline=circle(5.0), name="1"))
    if draw(st.booleans()):
        regions.append(Opening(outline=circle(3.0), boundary="tunnel"))
    faults = [Fault(name=f"F{number}", lines=[line]) for number, line in enumerate(lines)]
    return RockMass(regions=regions, joints=[*sets, *faults], seed=draw(st.integers(0, 99)))


@pytest.mark.heavy
@settings(max_examples=25, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow])
@given(networks())
@example(
    RockMass(
        regions=[Region(outline=box(-10, -10, 10, 10), rock="gneiss")],
        joints=[
            JointSet(name="J", dip=90, spacing=4.0, start=(2, 0)),
            Fault(name="F", lines=[[(0.0, -10.743), (0.077, -0.5), (0.0, -8.318)], [(-9, -0.50599), (9, -0.50599)]]),
        ],
    )
)
def test_both_engines_give_the_same_blocks(mass: RockMass) -> None:
    """To the tolerance to which each knows where lines cross, slivers joined; the example has one at a sharp corner.

    Of 2500 networks at random three are otherwise: a line that grazes a corner within the tolerance touches it for one
    engine and passes for the other, and where lines meet at a tenth of a degree lengths differ by millimetres.
    """
    one, other = cut_blocks(mass, "shapely"), cut_blocks(mass, "gmsh")
    assert one.count == other.count
    (first_areas, open_by), (other_areas, _) = (areas_within(cut, mass.grid) for cut in (one, other))
    assert (np.abs(first_areas - other_areas) <= open_by).all()
    for groups in ("joints", "boundaries"):
        first, second = lengths(one, getattr(one, groups)), lengths(other, getattr(other, groups))
        assert first.keys() == second.keys()
        assert first == pytest.approx(second, abs=1e-3)
    assert {name: len(ids) for name, ids in one.excavations.items()} == {
        name: len(ids) for name, ids in other.excavations.items()
    }


@pytest.mark.slow
@settings(max_examples=50, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow])
@given(networks())
def test_no_area_and_no_joint_is_lost(mass: RockMass) -> None:
    cut = cut_blocks(mass)
    whole = mass.domain().area
    assert areas(cut).min() > 0
    assert areas(cut).sum() == pytest.approx(whole, rel=AREA)
    edges = sum(len(edges) for groups in (cut.joints, cut.dead) for edges in groups.values()) + 10
    assert accounted(cut, 4 * mass.grid * edges)


@pytest.mark.heavy
@settings(max_examples=25, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow])
@given(networks())
def test_the_mesh_read_as_regions_gives_the_same_blocks(mass: RockMass) -> None:
    cut = cut_blocks(mass)
    with TemporaryDirectory() as folder:
        blocks, report = read_mesh(write_blocks(cut, Path(folder) / "rock.msh"), blocks="regions")
    assert report.count(NoteKind.FLAT) == 0
    assert blocks.moments.area.sum() == pytest.approx(mass.domain().area, rel=AREA)
    if not cut.holed.size:
        assert blocks.count == cut.count
        np.testing.assert_allclose(np.sort(blocks.moments.area), np.sort(areas(cut)), rtol=1e-9)
    for name, length in lengths(cut, dict(cut.boundaries)).items():
        assert np.hypot(*blocks.edge_vectors[blocks.boundaries[name]].T).sum() == pytest.approx(length, rel=1e-9)

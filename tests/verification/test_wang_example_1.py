"""Wang, section 3.4, Example 1 (Figs. 3.16-3.19): a circular tunnel in elastic rock under its own weight.

a = 2 m, H = 11 m, gamma = 26 kN/m3, E = 50 GPa, mu = 0.25. Half model, one linear step, the thesis's stiffness; rollers
left and bottom, the lateral pressure q = mu / (1 - mu) gamma h on the right, free surface. Fig. 3.17 gives no distances
to the right and the bottom: beyond 16 m and 14 m the stresses on section I-I change by 0.3 %, 22 m are taken.
"""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh import converters
from bsm_mesh.converters.continuum import blocks_on_line
from tests.scenes.models import LINEAR

A, DEPTH, GAMMA, MU, FAR = 2.0, 11.0, 26e3, 0.25, 22.0
K0 = MU / (1 - MU)
SECTION_L2, SECTION_MAX = (
    0.06,
    0.12,
)  # docs/theory_continuum.md: 1000 to 4000 triangles, block against averaged continuum
NEAR_L2 = {0.9: 0.12, 0.45: 0.08}  # docs/theory_continuum.md: all blocks r < 3a have 8.8 and 5.9 %
MATCHED_L2 = 0.05  # docs/theory_continuum.md: displacements, matched continuum, 4000 blocks; coarser ones hold it too
CONTINUUM = 0.015  # Eq. 3.46 takes gamma h for a uniform field: over the tunnel's height it is not


def eq_3_46(x, depth):
    """Return sigma_r, sigma_theta (tension positive) on section I-I, theta = 0."""
    p, q, k = GAMMA * depth, K0 * GAMMA * depth, (A / x) ** 2
    sigma_r = -(p + q) / 2 * (1 - k) + (p - q) / 2 * (1 + 3 * k**2 - 4 * k)
    sigma_theta = -(p + q) / 2 * (1 + k) - (p - q) / 2 * (1 + 3 * k**2)
    return sigma_r, sigma_theta


def l2_and_largest(difference, reference, area):
    l2 = np.sqrt((area * difference**2).sum() / (area * reference**2).sum())
    return l2, np.abs(difference).max() / np.abs(reference).max()


@pytest.fixture(scope="module", params=[0.9, 0.45])
def tunnel(request, tmp_path_factory):
    """Return the element size, the model, its results and the comparison with the continuum."""
    pytest.importorskip("gmsh")
    from bsm_mesh.geometries import circular_tunnel

    size = request.param
    path = circular_tunnel.build(
        tmp_path_factory.mktemp("tunnel") / "tunnel.msh",
        radius=A, depth=DEPTH, below=FAR, width=FAR, mesh="triangles",
        size=2.0 * size, size_at_wall=0.44 * size, grading_distance=10.0,
    )  # fmt: skip
    blocks = converters.read_blocks(path)
    model = bsm.Model(
        blocks=blocks,
        rocks=[bsm.Rock("rock", unit_weight=GAMMA, young=50e9, poisson=MU, stiffness="wang")],
        supports=[bsm.Roller(boundary="left", direction=0), bsm.Roller(boundary="bottom", direction=90)],
        loads=[bsm.Pressure(boundary="right", pressure=(K0 * GAMMA * DEPTH, 0.0, -K0 * GAMMA))],
    )
    results = bsm.run(model, LINEAR)
    assert results.check().ok
    return size, model, results, converters.compare(model, results)


def on_section(model, comparison):
    return comparison.along(blocks_on_line(model.blocks, (A, 0.0), (5 * A, 0.0)))


@pytest.mark.heavy
def test_number_of_blocks(tunnel):
    size, model, _, _ = tunnel
    low, high = {0.9: (900, 1500), 0.45: (3000, 5000)}[size]
    assert low < model.blocks.count < high


def test_vertical_stress_on_section_against_the_continuum(tunnel):
    _, model, _, comparison = tunnel
    section = on_section(model, comparison)
    fem = section.fem[:, 1, 1]
    l2, largest = l2_and_largest(section.bsm[:, 1, 1] - fem, fem, section.area)
    assert l2 <= SECTION_L2
    assert largest <= SECTION_MAX


def test_vertical_stress_on_section_against_eq_3_46(tunnel):
    """Fig. 3.19: the thesis calls its blocks very close to the analytical solution."""
    _, model, _, comparison = tunnel
    section = on_section(model, comparison)
    x, y = section.centroid.T
    _, exact = eq_3_46(x, DEPTH - y)
    assert l2_and_largest(section.fem[:, 1, 1] - exact, exact, section.area)[0] <= CONTINUUM
    l2, largest = l2_and_largest(section.bsm[:, 1, 1] - exact, exact, section.area)
    assert l2 <= SECTION_L2
    assert largest <= SECTION_MAX
    assert section.bsm[0, 1, 1] < -2 * GAMMA * DEPTH  # 3 p - q = 2.67 p at the wall itself


def test_stresses_near_the_tunnel(tunnel):
    size, model, _, comparison = tunnel
    near = np.hypot(*model.blocks.moments.centroid.T) < 3 * A
    difference, fem, area = (
        a[near] for a in (comparison.stress_difference, comparison.nominal.stress, comparison.area)
    )
    squares = [(area * (s**2).sum(axis=(1, 2))).sum() for s in (difference, fem)]
    assert np.sqrt(squares[0] / squares[1]) < NEAR_L2[size]


def test_displacements_against_matched_and_nominal_continuum(tunnel):
    """With nominal E the thesis's stiffness is 17-31 % off (docs/theory_continuum.md): that is the model, not a bug."""
    _, _, _, comparison = tunnel
    matched, nominal = comparison.displacement_errors
    assert matched.l2 < MATCHED_L2
    assert 0.17 < nominal.l2 < 0.35


def test_reactions_balance_in_both(tunnel):
    _, _, results, comparison = tunnel
    stage = results.stages[-1]
    for solution in (comparison.nominal, comparison.matched):
        assert_allclose(solution.total_load, stage.total_load, rtol=1e-9)
        assert_allclose(solution.total_reaction, stage.total_reaction, rtol=1e-7)

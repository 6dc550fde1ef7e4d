"""Everything that the main case assumes, one thing changed at a time."""

from dataclasses import replace

import bsm_mesh as bsm
from examples.cassiar_slope import slope

SIZES = (20, 30, 40, 45, 60, 80, 100)


def _stiffer(factor):
    return lambda joint: replace(joint, normal_stiffness=factor * joint.normal_stiffness)


def _friction(degrees):
    return lambda joint: replace(joint, law=replace(joint.law, friction=joint.law.friction + degrees))


def _rough(angle):
    """Return a change to asperities of an angle i, with the cohesion of Table 8.3."""
    cohesion = {24.0: 5.4e4, 30.0: 5.36e5}
    return lambda joint: replace(
        joint,
        law=bsm.Patton(friction=joint.law.friction, dilation=angle, cohesion=cohesion[joint.law.friction]),
    )


def _plastic(joint):
    return replace(joint, law=replace(joint.law, residual_cohesion=None))


def _serpentine(joint):
    return replace(joint, normal_stiffness=43e6, law=replace(joint.law, friction=24.0))


def _argillite(joint):
    return replace(joint, normal_stiffness=44e6, law=replace(joint.law, friction=30.0))


def _table_8_3(joint):
    return replace(joint, shear_stiffness=2.7e6 if joint.name in ("dyke", "contact") else 6.8e6)


def of_the_ground(base):
    """Yield name, model and points (None: those of the main case) with other numbers on the same mesh."""
    for degrees in (-2.0, 2.0):
        yield f"friction {degrees:+g} degrees", slope.with_joints(base, _friction(degrees)), None
    for angle in (2.0, 5.0, 10.0):
        yield f"asperities of {angle:g} degrees (0), Table 8.3's cohesion", slope.with_joints(base, _rough(angle)), None
    brittle = slope.load("mohr_coulomb")
    yield "Mohr-Coulomb joints, Table 8.3's cohesion, brittle", brittle, None
    yield "the same, perfectly plastic", slope.with_joints(brittle, _plastic), None
    yield "faults as weak as serpentinite", slope.with_joints(base, _serpentine, ("north_fault", "fault_a1")), None
    yield "dyke and contact as the argillite's", slope.with_joints(base, _argillite, ("dyke", "contact")), None
    for factor in (0.5, 2.0, 10.0):
        yield f"normal stiffness x {factor:g}", slope.with_joints(base, _stiffer(factor)), None
    yield "Ks of Table 8.3 without the star", slope.with_joints(base, _table_8_3), None
    for name, change in ROCK_FACES.items():
        yield f"faces of rock: {name}", slope.with_rocks(base, **change), None
    for part in (0.75, 0.85):
        yield f"high water at {part:g} of the height (0.8)", slope.with_levels(base, part), None
    yield "water tables straight from crest to toe", slope.with_levels(base, 0.8, shape=1.0), None
    yield "pressure of seepage parallel to the table (depth)", slope.with_head(base, "parallel"), None
    for k0 in (0.5, 1.0, 1.5):
        yield f"stress set first, K = {k0:g}", slope.with_k0(base, k0), None
    yield "contact points of Gauss", base.replace(contact_points="gauss"), None


ROCK_FACES = {  # shares of the mass's cohesion in Table 8.3; the table tells no tensile strength
    "Table 8.3, brittle, no tension": {"tensile_strength": 0.0, "residual_cohesion": 0.0},
    "Table 8.3, brittle, a fifth of the cohesion in tension": {"tensile_strength": 0.2, "residual_cohesion": 0.0},
    "Table 8.3, perfectly plastic, no tension": {"tensile_strength": 0.0},
    "Table 8.3, perfectly plastic, a fifth in tension": {"tensile_strength": 0.2},
}


def of_the_section(base):
    """Yield name, model and points with lines elsewhere."""
    for name, was, values in (
        ("north_fault_dip", 25, (20, 23, 27, 30, 35)),
        ("fault_a1_dip", 10, (5, 8, 12, 15)),
        ("fault_a1_length", 100, (80, 120)),
        ("fault_level", 120, (100, 140)),
        ("joint_dip", 20, (15, 25, 28, 30, 32)),
        ("joint_f_dip", 10, (5, 15)),
        ("joint_f_level", 30, (20, 45)),
        ("dyke_dip", 75, (65, 85)),
        ("dyke_setback", 20, (5, 40)),
        ("dyke_width", 15, (10, 25)),
        ("contact_dip", 60, (50, 70)),
        ("behind", 250, (400,)),
        ("ahead", 200, (400,)),
        ("below", 150, (300,)),
    ):
        for value in values:
            yield f"{name} = {value} ({was})", *slope.with_geometry(base, **{name: value})
    for angle in (38, 42):
        changed, points = slope.with_geometry(base, slope_angle=angle)
        yield f"slope_angle = {angle} (40)", slope.with_levels(changed, crest=points[0][0]), points


def of_the_mesh(base):
    """Yield name, model and points with other elements, and as ten rigid blocks."""
    for size in SIZES:
        yield f"elements of {size} m (50)", *slope.with_geometry(base, size=float(size))
    yield "ten rigid blocks", *slope.with_geometry(base, blocks="regions")
    for dip in (23, 27, 30, 33, 35, 36, 38):
        changed = slope.with_geometry(base, blocks="regions", north_fault_dip=dip)
        yield f"ten rigid blocks, north_fault_dip = {dip}", *changed

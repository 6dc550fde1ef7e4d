"""Every numbered equation of the thesis, chapters 3 to 6 and appendix B: what holds it, what proves it, or why not."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path

ROOT = Path(__file__).parents[1]
COUNTS = {"3": 47, "4": 17, "5": 22, "6": 7, "B": 18}
"""Equations by chapter: the last number of each."""


@dataclass(frozen=True, kw_only=True)
class Equation:
    """An equation, or some that one function holds together.

    Attributes
    ----------
    numbers : str
        The first and the last number, or one: "3.11-3.15", "4.8".
    what : str
        What it says.
    holds : tuple of str
        Functions and classes that hold it, ``module:name``; none where nothing is computed.
    tests : tuple of str
        Tests besides the cases, ``file::name`` in ``tests/``.
    note : str
        Where the program departs from it, or why it does not hold it.
    """

    numbers: str
    what: str
    holds: tuple[str, ...] = ()
    tests: tuple[str, ...] = ()
    note: str = ""

    @property
    def each(self) -> tuple[str, ...]:
        """The numbers one by one."""
        first, _, last = self.numbers.partition("-")
        chapter, _, low = first.partition(".")
        high = last.partition(".")[2] or low
        return tuple(f"{chapter}.{k}" for k in range(int(low), int(high) + 1))


def _k(name: str) -> str:
    return f"bsm_mesh.contact.kernels:{name}"


MODEL, BOLTS, WATER = "bsm_mesh.model.model:Model", "bsm_mesh.solve.bolts", "bsm_mesh.model.water_kernels"
DERIVATION = "a step of the derivation of B.18: nothing to compute"

EQUATIONS: tuple[Equation, ...] = (
    Equation(numbers="3.1-3.7", what="displacement of a point of a rigid block: {u} = [B]{U}",
             holds=(_k("spring_forces"),),
             tests=("unit/test_linear.py::test_opening_and_slip_are_the_displacements_of_a_relative_to_b",)),
    Equation(numbers="3.8-3.10", what="displacement of two blocks relative to each other: [D]{U}",
             holds=(_k("spring_forces"),)),
    Equation(numbers="3.11-3.15", what="forces of the springs of a contact: [k][T][D]{U}", holds=(_k("spring_forces"),),
             tests=("verification/test_block_on_incline.py::test_two_springs",)),
    Equation(numbers="3.16-3.17", what="force and moment of a contact on a block", holds=(_k("add_contact_forces"),)),
    Equation(numbers="3.18-3.19", what="stiffness matrix of a contact",
             holds=("bsm_mesh.solve.algebra.block_matrix:fill_stiffness",),
             tests=("unit/test_block_matrix.py::test_values_against_dense_sums",),
             note="kept with the opposite sign, so that it is positive"),
    Equation(numbers="3.20-3.21", what="E' and G of plane strain",
             holds=("bsm_mesh.model.materials:confined_modulus", "bsm_mesh.model.materials:shear_modulus")),
    Equation(numbers="3.22-3.24", what="strain over the distance of the centroid: E'/h, G/h",
             holds=("bsm_mesh.model.face_stiffness:face_stiffness", "bsm_mesh.model.materials:Rock"),
             tests=("verification/test_continuum_moduli.py::test_squares",),
             note="one of three stiffnesses, and the default; what it makes of rock: "
             "[theory](theory_continuum.md)"),
    Equation(numbers="3.25-3.26", what="two rocks in series; filling",
             holds=("bsm_mesh.model.face_stiffness:face_stiffness", "bsm_mesh.model.materials:Filling")),
    Equation(numbers="3.27", what="rock and joint in series", holds=("bsm_mesh.model.face_stiffness:compliance",)),
    Equation(numbers="3.28-3.29", what="displacement of a held point along a bar",
             holds=("bsm_mesh.solve.algebra.constraints:constrain_bars", "bsm_mesh.model.supports:unit_vector"),
             tests=("unit/test_constraints.py::test_given_displacements_satisfy_every_bar",)),
    Equation(numbers="3.30-3.35", what="reaction and stiffness of a boundary bar",
             holds=("bsm_mesh.solve.algebra.constraints:Constraints", "bsm_mesh.solve.algebra.reactions:bar_forces"),
             tests=("verification/test_against_lagrange_multipliers.py::test_against_a_dense_solution",
                    "unit/test_constraints.py::test_bar_forces_add_up_to_the_reaction"),
             note="by exact elimination; the thesis's bar is its limit for an infinite stiffness"),
    Equation(numbers="3.36-3.37", what="weights", holds=(f"{MODEL}.weights", f"{MODEL}.gravity_forces")),
    Equation(numbers="3.38", what="loads at points", holds=("bsm_mesh.solve.algebra.loads:external_loads",)),
    Equation(numbers="3.39", what="equilibrium of a block", holds=("bsm_mesh.results.results:Results.check",),
             tests=("verification/test_equilibrium.py::test_a_wall_in_bond_on_soft_joints_beside_hard_ones",)),
    Equation(numbers="3.40-3.41", what="[K]{U} = {P}", holds=("bsm_mesh.solve.linear.system:LinearSystem",),
             tests=("verification/test_against_lagrange_multipliers.py::test_against_a_dense_solution",)),
    Equation(numbers="3.42", what="half-band-width of [K]",
             note="not held: the matrix is sparse, in blocks of 3 x 3, and not banded "
             "([decision](decisions/0002-linear-solvers.md))"),
    Equation(numbers="3.43-3.45", what="average stress of a block", holds=("bsm_mesh.results.stress:block_stress",)),
    Equation(numbers="3.46", what="stresses round a circular opening",
             tests=("verification/test_kirsch.py::test_formula",),
             note="not the program's: an exact solution that blocks and elements are compared with"),
    Equation(numbers="3.47", what="primary stress: p = gamma h, q = mu / (1 - mu) p",
             holds=("bsm_mesh.model.stress_field:StressField",)),
    Equation(numbers="4.1-4.2", what="Patton's two lines",
             holds=("bsm_mesh.model.joint_laws.patton:Patton.strength_lines",)),
    Equation(numbers="4.3", what="strength by Ladanyi and Archambault",
             holds=("bsm_mesh.model.joint_laws.ladanyi_archambault:LadanyiArchambault.respond",)),
    Equation(numbers="4.4", what="its limit at low stress",
             holds=("bsm_mesh.model.joint_laws.ladanyi_archambault:LadanyiArchambault.respond",),
             note="with the authors' a_s = 1 - (1 - s/c)^1.5 the term a_s S_r / s does not vanish: it "
             "adds 1.5 S_r / c to the slope"),
    Equation(numbers="4.5", what="its limit at high stress",
             holds=("bsm_mesh.model.joint_laws.ladanyi_archambault:LadanyiArchambault.respond",)),
    Equation(numbers="4.6-4.7", what="strength by Barton and Bandis",
             holds=("bsm_mesh.model.joint_laws.barton_bandis:BartonBandis.respond",),
             note="the angle is 70 degrees at most"),
    Equation(numbers="4.8", what="the lower of Patton's lines, as a criterion",
             holds=("bsm_mesh.model.joint_laws.patton:Patton.respond", "bsm_mesh.contact.strength:peak_strength"),
             tests=("unit/test_joint_laws.py::test_patton_crosses_where_it_should",)),
    Equation(numbers="4.9", what="no tension", holds=("bsm_mesh.contact.forces:evaluate",),
             tests=("unit/test_joint_laws.py::test_under_tension_there_is_no_friction",),
             note="joints may have a tensile strength"),
    Equation(numbers="4.10", what="increment of the displacements in a cycle",
             holds=("bsm_mesh.solve.continuation.wang:WangIteration.run",),
             tests=("verification/test_wang_iteration.py::test_cycles_of_a_slide",),
             note='`scheme = "wang"`, with six corrections '
             '([decision](experiments/thesis_scheme.md))'),
    Equation(numbers="4.11", what="new coordinates of a point",
             holds=("bsm_mesh.contact.force_kernels:relative_positions", f"{BOLTS}.kernels:node_movements"),
             note="rotations are exact: with [B]{U} blocks grow"),
    Equation(numbers="4.12-4.13", what="increments are added up",
             holds=("bsm_mesh.solve.continuation.wang:WangIteration.run", "bsm_mesh.contact.history:commit"),
             tests=("verification/test_wang_iteration.py::test_where_nothing_fails_one_cycle_is_the_linear_scheme",)),
    Equation(numbers="4.14", what="vertical stress of the ground", holds=("bsm_mesh.model.stress_field:StressField",),
             tests=("unit/test_in_situ.py::test_overburden_through_many_rocks",)),
    Equation(numbers="4.15-4.17", what="horizontal over vertical stress",
             holds=("bsm_mesh.model.in_situ:STRESS_RATIOS", "bsm_mesh.model.stress_field:StressField"),
             tests=("unit/test_in_situ.py::test_ratios_of_horizontal_to_vertical_stress",)),
    Equation(numbers="5.1", what="tension of an end-anchored bolt", holds=(f"{BOLTS}.chain:solve_chain",)),
    Equation(numbers="5.2", what="its stiffness",
             holds=("bsm_mesh.model.bolts:Bolt.axial_stiffness", f"{BOLTS}.installed:InstalledBolts"),
             tests=("verification/test_bolts.py::test_stiffness_times_length_instead_of_modulus_and_diameter",)),
    Equation(numbers="5.3-5.4", what="yield and anchorage", holds=(f"{BOLTS}.chain:solve_chain",),
             tests=("verification/test_bolts.py::test_capacity_below_and_above_the_weight",)),
    Equation(numbers="5.5", what="tension of an element of a grouted bolt",
             holds=(f"{BOLTS}.installed:InstalledBolts.evaluate",)),
    Equation(numbers="5.6", what="its force on the rock", holds=(f"{BOLTS}.installed:InstalledBolts.evaluate",),
             tests=("unit/test_bolt_chain.py::test_slips_and_laws_are_consistent",)),
    Equation(numbers="5.7", what="strength of the bond", holds=("bsm_mesh.model.bolts:Bolt.bond_capacity",)),
    Equation(numbers="5.8-5.13", what="redistribution when the bond fails", holds=(f"{BOLTS}.chain:solve_chain",),
             tests=("unit/test_bolt_chain.py::test_a_single_sweep_is_far_off",),
             note="its end, found at once; a single sweep may be far off"),
    Equation(numbers="5.14-5.17", what="elongation and tension from the blocks' displacements",
             holds=(f"{BOLTS}.kernels:node_movements", f"{BOLTS}.kernels:element_lines"),
             note="lengths are exact; the thesis's are their first order"),
    Equation(numbers="5.18-5.20", what="forces on the blocks", holds=(f"{BOLTS}.kernels:add_bolt_forces",),
             tests=("verification/test_bolts.py::test_forces_of_bolts_are_in_balance_with_themselves",)),
    Equation(numbers="5.21", what="stiffness matrix of a bolt", holds=(f"{BOLTS}.kernels:add_bolt_tangent",),
             tests=("unit/test_bolt_forces.py::test_tangent",),
             note="with the bolt's turning under its tension besides, but in the linear scheme"),
    Equation(numbers="5.22", what="increments of bolt forces; pretension",
             holds=(f"{BOLTS}.installed:InstalledBolts.commit", f"{BOLTS}.installed:InstalledBolts.install"),
             tests=("verification/test_bolts.py::test_pretension_compresses_the_joints_between_its_ends",)),
    Equation(numbers="6.1", what="pressure by vertical depth",
             holds=(f"{WATER}:end_forces", "bsm_mesh.model.water_pressure:WaterLoad.pressure"),
             note='`head = "parallel"` takes seepage along the table instead'),
    Equation(numbers="6.2", what="forces at the ends of a submerged face", holds=(f"{WATER}:end_forces",)),
    Equation(numbers="6.3-6.5", what="the same of a partly submerged face", holds=(f"{WATER}:end_forces",)),
    Equation(numbers="6.6-6.7", what="components, and their part of {P}",
             holds=(f"{WATER}:add_face_forces", "bsm_mesh.solve.algebra.loads:external_loads")),
    Equation(numbers="B.1", what="average stress: its definition", holds=("bsm_mesh.results.stress:block_stress",)),
    Equation(numbers="B.2-B.12", what="equilibrium, Green's theorem, two integrals", note=DERIVATION),
    Equation(numbers="B.13", what="the weight drops out", holds=("bsm_mesh.results.stress:block_stress",),
             tests=("verification/test_average_stress.py::test_weight_between_rollers",)),
    Equation(numbers="B.14-B.15", what="tractions on the boundary", note=DERIVATION),
    Equation(numbers="B.16-B.18", what="average stress from forces on the outline",
             holds=("bsm_mesh.results.stress:block_stress", _k("add_contact_moments")),
             tests=("verification/test_average_stress.py::test_loads_and_supports_count_as_contacts_do",
                    "unit/test_stress.py::test_contact_forces_on_both_blocks")),
)  # fmt: skip


def all_numbers() -> Iterator[str]:
    """Yield the numbers of the thesis's equations."""
    for chapter, count in COUNTS.items():
        yield from (f"{chapter}.{k}" for k in range(1, count + 1))


def is_there(name: str) -> bool:
    """Return whether a function, class or attribute ``module:name`` of the program exists."""
    module, _, path = name.partition(":")
    at = import_module(module)
    for part in path.split("."):
        if not hasattr(at, part):
            return False
        at = getattr(at, part)
    return True


@cache
def _tests_in(file: str) -> frozenset[str]:
    tree = ast.parse((ROOT / "tests" / file).read_text(encoding="utf-8"))
    return frozenset(node.name for node in tree.body if isinstance(node, ast.FunctionDef))


def is_a_test(name: str) -> bool:
    """Return whether a test ``file::name`` exists."""
    file, _, test = name.partition("::")
    return (ROOT / "tests" / file).is_file() and test.startswith("test_") and test in _tests_in(file)


def file_of(name: str) -> str:
    """Return the file of a function, relative to the checkout."""
    return name.partition(":")[0].replace(".", "/") + ".py"

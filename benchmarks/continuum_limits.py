"""Closed forms, slopes under gravity, refinement, bolts, a large continuum: ``python -m benchmarks.continuum_limits``.

Slopes are those of the campaign's families, with gravity switched on from zero stress, where friction leaves the
equilibrium undetermined: the first ten seeds whose blocks reach rest, both equilibria checked. With ``--into PAGE``
the tables take the place of what is between that page's marks.
"""

from __future__ import annotations

import argparse
import dataclasses
import sys
import time
from collections.abc import Iterator

import numpy as np

import bsm_mesh as bsm
from benchmarks.campaign.families.slopes import draw_leaning, draw_slope
from benchmarks.continuum import ROOT
from benchmarks.pages import add_into, tell
from bsm_mesh.converters.continuum import compare_stages, solve_continuum, solve_continuum_stages
from bsm_mesh.modelfile.build import load_model_file
from bsm_mesh.results.records import ContactStatus
from bsm_mesh.text.tables import engineering
from examples.numbers.pages import markdown
from tests.scenes.continuum import bolted, cantilever, on_a_slope, sag
from tests.scenes.kirsch import cut_by_stages
from tests.scenes.large import blocky_rock

SLOPES = 10
MOST_SEEDS = 100
SAYING = "Greatest displacement of a block in the elements, and how many blocks refining moves by more than a tenth:"
LARGE, HALVINGS = 1000, 2  # Voronoi blocks, and how often their fans are halved: 1e5 triangles
ROCK = {"young": 20e9, "poisson": 0.2}
SLOPES_SAYING = (
    "Rigid blocks on joints of friction, gravity switched on at once: friction leaves the equilibrium undetermined, "
    "and each method finds its own; the table says how far apart they are:"
)
HEADER = ("seed", "family", "blocks", "joints that slip or are open", "balance checked", "what compare says")
REFINED = ("04_bolted_opening/model", "05_dam_foundation/model", "cassiar_slope/ten_blocks")  # in elastic rock
REFINEMENTS = 3
LEVELS = (
    "model",
    "stage",
    "as given",
    *(f"halved {k} times" for k in range(1, REFINEMENTS + 1)),
    "limit",
    "too coarse",
)
BEAM = (8, 16, 32)  # columns of squares of a cantilever, whose sag is measured on FINE columns of second order
FINE = 128
ELEMENTS = ("blocks", "Poisson's ratio", "order", "quads", "four triangles each")
ELEMENTS_SAYING = (
    "A cantilever of squares as quads, and with one triangle at its end: by how much its sag is short of a fine mesh's:"
)
TUNNEL, MODULI = "staged_tunnel/model", (10e9, 20e9, 50e9, 100e9)
ROCKS = ("joints", "rock", "stage", "what compare says", "of elements begun where the blocks rest")
ROCKS_SAYING = (
    "The tunnel by stages, in elastic rock instead of rigid. Joints that break leave several equilibria: the last "
    "column is of another of the elements, found from where the blocks reached rest:"
)
TUNNELS, STIFFER = ("staged_tunnel/model", "staged_tunnel/weak"), (1, 10, 100)
RIGID = ("model", "stiffness of the joints", "stage", "displacement by", "joint forces by", "blocks", "elements")
RIGID_SAYING = (
    "Tunnels by stages in rigid rock. Joints so many times as stiff leave all forces as they are and make "
    "displacements so many times smaller, so that no corner meets another at a node of the mesh:"
)
KIRSCH = 24  # blocks along a quarter of the hole
ANGLE = 1e-4  # degrees; to which the limit of a slope is sought
CLOSED = ("closed form", "what", "found, or off by")
CLOSED_SAYING = "Closed forms, by the elements alone:"
BOLTED = ("04_bolted_opening/model", "04_bolted_opening/two_bolts")
LOAD_PARTS = (1.0, 0.1, 0.01)
BOLT_LEVELS = ("model", "rock", "part of the loads", "bolt forces differ by", "joint forces by", "displacement by")
BOLTS_SAYING = "Bolted openings under parts of their loads:"
COMMAND = "python -m benchmarks.continuum_limits"


def slope(seed: int) -> tuple[str, bsm.Model]:
    """Return a random slope of rigid blocks whose gravity is switched on at once, and its family."""
    family, draw = (("slope", draw_slope), ("leaning", draw_leaning))[seed % 2]
    scene = draw(np.random.default_rng(seed)).scene
    return family, dataclasses.replace(scene, k0=None).model()


def slope_rows() -> Iterator[tuple[str, ...]]:
    """Return a row for each of the first slopes at rest that small displacements hold for."""
    found, skipped = 0, 0
    for seed in range(MOST_SEEDS):
        family, model = slope(seed)
        results = bsm.run(model)
        (stage,) = compare_stages(model, results, refine=False)
        print(f"slope {seed}: {stage.sentence}", file=sys.stderr, flush=True)
        compared = stage.comparison
        if compared is None and "finite elements" not in stage.reason:
            skipped += 1
            continue
        found += 1
        checked, shares = "blocks" if results.check().ok else "none", "-"
        if compared is not None:
            checked = "both" if results.check().ok and compared.nominal.converged else checked
            shares = " and ".join(f"{100 * share:.0f} %" for share in compared.slipping)
        yield str(seed), family, str(model.blocks.count), shares, checked, stage.sentence
        if found == SLOPES:
            break
    yield "", "", "", "", "", f"{skipped} seeds between them collapse, or move too far for small displacements"


def refined_rows() -> Iterator[tuple[str, ...]]:
    """Return a row a stage of the examples whose elements and interfaces are halved."""
    for name in REFINED:
        loaded = load_model_file(ROOT / "examples" / f"{name}.toml", lambda _: None)
        results = bsm.run(loaded.model, loaded.options)
        for stage in compare_stages(loaded.model, results, refinements=REFINEMENTS):
            study = None if stage.comparison is None else stage.comparison.refinement
            if study is None:
                continue
            greatest = [engineering(level.greatest, "m") for level in study.levels]
            greatest += ["no equilibrium"] * (REFINEMENTS + 1 - len(greatest))
            limit = "-" if study.greatest_limit is None else engineering(study.greatest_limit, "m")
            coarse = f"{study.too_coarse.size} of {loaded.model.blocks.count} blocks"
            yield name, stage.name, *greatest, limit, coarse
            print(f"{name}, {stage.name}: {study.sentence}", file=sys.stderr, flush=True)


def closed_rows() -> Iterator[tuple[str, ...]]:
    """Return a row for every closed form."""
    model, exact, at_wall = cut_by_stages(KIRSCH)
    for order in (1, 2):
        stress = solve_continuum_stages(model, order=order)[-1].stress[: len(exact)]
        off = np.linalg.norm((stress - exact)[at_wall]) / np.linalg.norm(exact[at_wall])
        what = f"Kirsch's hole cut in situ, {KIRSCH} blocks along a quarter, order {order}"
        yield what, "stress of the blocks at the wall", f"{100 * off:.2g} % (L2)"
    for friction in (20.0, 35.0):
        low, high = friction - 1, friction + 1
        while high - low > ANGLE:
            middle = (low + high) / 2
            stage = solve_continuum(on_a_slope(middle, friction, ROCK), order=1, joints=True)
            low, high = (middle, high) if stage.converged else (low, middle)
        yield f"block on a slope, friction {friction:g} degrees", "slides beyond", f"{(low + high) / 2:.3f} degrees"
    water = bsm.Water(table=[(-5, 3.0), (5, 3.0)], unit_weight=10e3)
    stage = solve_continuum(on_a_slope(0.0, 30.0, ROCK).replace(water=water), order=2, joints=True)
    off = abs(float(stage.contacts.normal_force.sum()) / (-(26e3 - 10e3) * 0.4) - 1)
    yield "block under water (Archimedes)", "force in its joint", f"{off:.1g} of it"


def element_rows() -> Iterator[tuple[str, ...]]:
    """Return a row for every mesh of a cantilever."""
    for poisson in (0.2, 0.45):
        fine = cantilever(FINE, poisson, mixed=False)
        exact = sag(fine, solve_continuum(fine).displacement)
        for order in (1, 2):
            for columns in BEAM:
                short = []
                for mixed in (False, True):
                    model = cantilever(columns, poisson, mixed=mixed)
                    short.append(1 - sag(model, solve_continuum(model, order=order).displacement) / exact)
                errors = (f"{100 * error:.2g} %" for error in short)
                yield f"{columns} x {columns // 4}", f"{poisson:g}", str(order), *errors


def rigid_rows() -> Iterator[tuple[str, ...]]:
    """Return a row for every tunnel in rigid rock, stiffness of its joints and stage."""
    for name in TUNNELS:
        loaded = load_model_file(ROOT / "examples" / f"{name}.toml", lambda _: None)
        for times in STIFFER:
            stiffness = ("normal_stiffness", "shear_stiffness")
            joints = [
                dataclasses.replace(joint, **{part: times * getattr(joint, part) for part in stiffness})
                for joint in loaded.model.joints
            ]
            model = loaded.model.replace(joints=joints)
            results = bsm.run(model, loaded.options)
            elements = solve_continuum_stages(model, order=1, joints=True)
            for number, stage in enumerate(compare_stages(model, results, refine=False)):
                compared, off = stage.comparison, ("-", "-")
                if compared is not None and compared.force_error is not None:
                    moves = [f"{100 * error.l2:.2g} %" for error in compared.displacement_errors] or ["nothing moves"]
                    off = moves[0], f"{100 * compared.force_error.l2:.2g} %"
                found = "-" if number >= len(elements) else "equilibrium" if elements[number].converged else "none"
                verdict = results.stages[number].status.value.replace("_", " ")
                stiff = "as given" if times == 1 else f"{times} times"
                yield name, stiff, stage.name, *off, verdict, found


def rock_rows() -> Iterator[tuple[str, ...]]:
    """Return a row for every modulus of the rock about a tunnel by stages, and stage."""
    loaded = load_model_file(ROOT / "examples" / f"{TUNNEL}.toml", lambda _: None)
    given = loaded.model.joints
    elastic = [dataclasses.replace(joint, law=None, tensile_strength=0.0) for joint in given]
    for what, joints in (("as given", given), ("elastic", elastic)):
        for young in MODULI:
            rocks = [dataclasses.replace(rock, young=young, poisson=0.2) for rock in loaded.model.rocks]
            model = loaded.model.replace(rocks=rocks, joints=joints)
            results = bsm.run(model, loaded.options)
            near = "-"
            for stage in compare_stages(model, results, refine=False)[1:]:
                if joints is given and stage.name == model.stages[0].name:
                    first = model.replace(stages=model.stages[:1])
                    near = compare_stages(first, bsm.run(first, loaded.options), refine=False, near_blocks=True)[
                        1
                    ].sentence
                yield what, f"{young / 1e9:g} GPa", stage.name, stage.sentence, near
                near = "-"


def bolt_rows() -> Iterator[tuple[str, ...]]:
    """Return a row for every bolted example, rock and part of the loads."""
    for name in BOLTED:
        loaded = load_model_file(ROOT / "examples" / f"{name}.toml", lambda _: None)
        for rigid in (False, True):
            for load in LOAD_PARTS:
                model = bolted(loaded.model, load=load, rigid=rigid)
                (stage,) = compare_stages(model, bsm.run(model, bsm.Options(tolerance=1e-9)), refine=False)
                compared = stage.comparison
                if compared is None or compared.force_error is None or compared.bolt_error is None:
                    raise SystemExit(f"{name}: {stage.sentence}")
                errors = compared.bolt_error, compared.force_error, compared.displacement_errors[0]
                rock = "rigid" if rigid else "as given"
                yield name, rock, f"{load:g}", *(f"{100 * error.l2:.2g} %" for error in errors)


def large_model() -> bsm.Model:
    """Return elastic Voronoi rock at depth, of which a stage excavates a circle."""
    model = blocky_rock(LARGE).model(0.5)
    return model.replace(rocks=[dataclasses.replace(rock, **ROCK) for rock in model.rocks])


def large_text() -> str:
    """Return what solving the large continuum took."""
    model = large_model()
    began, used = time.perf_counter(), time.process_time()
    stages = solve_continuum_stages(model, order=1, joints=True, refinements=HALVINGS)
    seconds, processor = time.perf_counter() - began, time.process_time() - used
    last = stages[-1]
    slipping = (last.contacts.status != ContactStatus.STICKING).mean()
    return (
        f"An excavation in {model.blocks.count} Voronoi blocks at depth, every side halved {HALVINGS} times: "
        f"{len(last.cell_block)} triangles, {last.contacts.length.size // 2} interface faces, {last.unknowns} "
        f"unknowns, in-situ state and excavation, {100 * slipping:.2g} % of the points slipping or open at the end: "
        f"{processor:.0f} s of one processor ({seconds:.0f} s on the wall, which other programs shared); "
        f"{'equilibrium in both stages' if all(stage.converged for stage in stages) else 'no equilibrium'}."
    )


def main() -> int:
    """Make the tables, and print them or put them into a page."""
    parser = argparse.ArgumentParser(description=__doc__)
    add_into(parser, COMMAND)
    given = parser.parse_args()
    parts = [
        *(CLOSED_SAYING, markdown(CLOSED, closed_rows()), SLOPES_SAYING, markdown(HEADER, slope_rows())),
        *(SAYING, markdown(LEVELS, refined_rows()), RIGID_SAYING, markdown(RIGID, rigid_rows())),
        *(ROCKS_SAYING, markdown(ROCKS, rock_rows()), ELEMENTS_SAYING, markdown(ELEMENTS, element_rows())),
        *(BOLTS_SAYING, markdown(BOLT_LEVELS, bolt_rows()), large_text()),
    ]
    tell("\n\n".join(parts), COMMAND, given.into)
    return 0


if __name__ == "__main__":
    sys.exit(main())

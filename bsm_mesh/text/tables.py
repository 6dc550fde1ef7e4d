"""Tables for the terminal, and numbers as an engineer writes them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.errors import counted, listing, named_stage, numbered, one_line, place
from bsm_mesh.movements import distances, lengths, translations
from bsm_mesh.results.bolts import BoltForces, BoltLimit, BoltStatus
from bsm_mesh.results.joint_faces import AT_STRENGTH
from bsm_mesh.results.joint_sets import ROCK_FACE, joint_sets
from bsm_mesh.results.movement import greatest_displacement, share_in_words, verdict_in_words
from bsm_mesh.results.records import StageResult
from bsm_mesh.results.results import Results
from bsm_mesh.results.spread import RouteEnd
from bsm_mesh.results.stress import extreme_stresses, extreme_zone_stresses
from bsm_mesh.text.flow_text import discharge_text, how_solved

PREFIXES = ((1e9, 1e9, "G"), (1e6, 1e6, "M"), (1e3, 1e3, "k"), (1.0, 1.0, ""))
SMALL_PREFIXES = (*PREFIXES, (1e-6, 1e-3, "m"), (1e-9, 1e-6, "u"))
MEASURED_SMALL = ("m", "s")  # mPa and mN are not written in this field, and mPa is read as MPa
LONGEST_WORD = 13  # letters of a wrapped text that stay together where other columns are wide
ROUNDING = 1e-12  # m, or of the whole: no slip, no share
OF_BOLTS = {  # words behind a utilisation
    BoltLimit.NONE: "",
    BoltLimit.STEEL: " of the steel",
    BoltLimit.BOND: " of bond, plate or anchorage",
    BoltLimit.DOWEL: " of the dowel",
}
SQUARED = ("m2", "m3")  # have no prefix: a mm2 is no thousandth of a m2


def engineering(value: float, unit: str) -> str:
    """Return a number with an SI prefix; small lengths stay in mm.

    Examples
    --------
    >>> engineering(-2.4537e6, "Pa")
    '-2.454 MPa'
    >>> engineering(0.0, "m")
    '0 m'
    >>> engineering(0.7189, "m2")
    '0.7189 m2'
    >>> engineering(0.00025, "m"), engineering(0.00025, "Pa")
    ('0.25 mm', '0.00025 Pa')
    """
    if value == 0 or not math.isfinite(value):
        return f"{value:g} {unit}"
    prefixes = () if unit in SQUARED else SMALL_PREFIXES if unit in MEASURED_SMALL else PREFIXES
    factor, prefix = next(((f, p) for least, f, p in prefixes if abs(value) >= least), (1.0, ""))
    return f"{value / factor:.4g} {prefix}{unit}"


def print_table(
    title: str, header: Sequence[str], rows: Sequence[Sequence[str]], *, texts: int = 1, last_wraps: bool = False
) -> None:
    """Print a table on stdout; the first `texts` columns stand to the left and may wrap, the others to the right."""
    from rich import box
    from rich.console import Console
    from rich.table import Table

    table = Table(box=box.SIMPLE, show_header=any(header))
    console = Console(highlight=False, markup=False, emoji=False)
    widest_cells = [max(map(len, (name, *(row[k] for row in rows)))) for k, name in enumerate(header)]
    # numbers wrap rather than lose their end, where they alone are too wide beside the words of texts
    least = [min(cell, LONGEST_WORD) if k < texts else cell for k, cell in enumerate(widest_cells)]
    is_crowded = len(header) > 2 and sum(least) + 3 * len(header) > console.width
    name_fits = widest_cells[0] + min(widest_cells[-1], LONGEST_WORD) + 3 * len(header) <= console.width
    for number, name in enumerate(header):
        is_text = number < texts
        # of a thing and its value the value wraps where both are too wide, and the thing stays if it leaves room for it
        no_wrap = number == 0 and name_fits if len(header) == 2 else not is_text or (number == 0 and texts > 1)
        no_wrap = no_wrap and not (last_wraps and number == len(header) - 1) and (is_text or not is_crowded)
        words = [] if no_wrap else " ".join([name, *(row[number] for row in rows)]).split()
        widest = min(max(map(len, words), default=1), LONGEST_WORD)
        width = widest if is_text and is_crowded and not no_wrap else None
        table.add_column(name, justify="left" if is_text else "right", no_wrap=no_wrap, min_width=widest, width=width)
    for row in rows:
        table.add_row(*map(one_line, row))
    console.print(one_line(title), style="bold")
    console.print(table)


def vector(components: Iterable[float], unit: str) -> str:
    """Return the components of a vector; a component within rounding of the greatest is shown as 0."""
    parts = [float(c) for c in components]
    greatest = max(abs(c) for c in parts)
    return ", ".join(engineering(c if abs(c) > 1e-9 * greatest else 0.0, unit) for c in parts)


def bolt_rows(bolts: BoltForces) -> list[tuple[str, str]]:
    """Return greatest force and greatest utilisation, which need not be of one bolt, and the bolts' states."""
    if (bolts.status == BoltStatus.ABSENT).all():
        return [("bolts", _bolt_counts(bolts))]
    worst, greatest = int(bolts.greatest_force.argmax()), "0"
    if bolts.utilisation.any():
        element = int(bolts.utilisation.argmax())
        bolt = int(bolts.bolt[element])
        greatest = (
            f"{most_used(bolts, bolt)} ({bolts.names[bolt]}, {bolts.station[element + bolt]:.3g} m from its head, "
            f"where its force is {engineering(float(bolts.axial_force[element]), 'N')})"
        )
    return [
        ("greatest force in a bolt", f"{engineering(float(bolts.greatest_force[worst]), 'N')} ({bolts.names[worst]})"),
        ("greatest utilisation of a bolt", greatest),
        ("bolts", _bolt_counts(bolts)),
    ]


def most_used(bolts: BoltForces, bolt: int) -> str:
    """Return the greatest utilisation along a bolt, and the strength that it is a part of."""
    mine = np.flatnonzero(bolts.bolt == bolt)
    if not mine.size:
        return "0"
    element = mine[bolts.utilisation[mine].argmax()]
    return f"{bolts.utilisation[element]:.3g}{OF_BOLTS[BoltLimit(int(bolts.limit[element]))]}"


def _bolt_counts(bolts: BoltForces) -> str:
    """Return how many bolts are in each state, and the first few by name that are at a limit, or within 1 % of it."""
    told = []
    used = np.zeros(bolts.count)
    np.maximum.at(used, bolts.bolt, bolts.utilisation)
    for status in BoltStatus:
        mine = np.flatnonzero((bolts.status == status) & ~bolts.alone)
        limited = status in (BoltStatus.SLIPPING, BoltStatus.YIELDING)
        named = mine if limited else mine[used[mine] >= AT_STRENGTH]  # slipped, and rests just below its strength
        names = ", ".join(bolts.names[k] for k in named[:6]) + (", ..." if len(named) > 6 else "")
        if mine.size:
            within = "" if limited else "within 1 % of their strength: "
            told.append(f"{len(mine)} {status.name.lower()}" + (f" ({within}{names})" if named.size else ""))
    if bolts.alone.any():
        told.append(f"{int(bolts.alone.sum())} in a single block, without effect")
    return ", ".join(told)


EXTREMES = ("most compressive stress (sigma_1)", "most tensile stress (sigma_3)")


def describe(results: Results, stage: StageResult | None = None, *, verbose: bool = False) -> list[tuple[str, str]]:
    """Return the verdict on a stage, the last by default, and the numbers that a reader asks for first.

    Terminal, notebook and report take their words from here; `verbose` adds how the solution was found.
    """
    stage, blocks = stage or results.stages[-1], results.blocks
    unfinished = not results.finished and stage is results.stages[-1]
    *means, unknown = extreme_stresses(blocks, stage)
    without = f" ({counted(unknown, 'block')} excluded: supported, or slivers)" if unknown else ""
    rows = [
        ("verdict", results.status.value if unfinished else verdict_in_words(blocks, stage)),
        ("reason", stage.reason),
    ]
    if stage.unstable_blocks.size:
        rows.append(("falls", falling(results, stage)))
    if stage is results.stages[-1] and results.not_computed:
        rows.append(("stages not computed", ", ".join(results.not_computed)))
    rows += [
        ("blocks", f"{int(stage.present.sum())}"),
        ("greatest displacement", _greatest_displacement(results, stage)),
        *(
            (name, engineering(mean, "Pa") + without if stage.zones is None else _in_zones(zone, mean, without))
            for name, mean, zone in zip(EXTREMES, means, extreme_zone_stresses(stage), strict=True)
        ),
        (f"weights and loads ({blocks.components})", vector(stage.total_load, blocks.force_unit)),
        *_water_rows(results, stage),
        (f"reactions ({blocks.components})", vector(stage.total_reaction, blocks.force_unit)),
    ]
    if stage.bolts.count:
        rows += bolt_rows(stage.bolts)
    overstressed = int((stage.contacts.utilisation > 1).sum())
    if overstressed and results.scheme == "linear":
        rows.append(("contacts beyond their shear strength", f"{overstressed} (this scheme lets none of them slip)"))
    rows.append(("time of the solution", f"{stage.seconds:.3g} s"))
    return rows + (_solution_rows(results, stage) if verbose else [])


def _in_zones(stress: float, mean: float, without: str) -> str:
    """Return an extreme stress of a zone and of the means of blocks, both in Pa."""
    return f"{engineering(stress, 'Pa')} in a zone; mean of a block {engineering(mean, 'Pa')}{without}"


def falling(results: Results, stage: StageResult) -> str:
    """Return the blocks that fall at the end of a stage: number, weight, area (in space: volume), share."""
    down, bulk, unit = stage.unstable_blocks, results.blocks.moments.bulk, results.blocks.bulk_unit
    fallen = float(bulk[down].sum())
    weight = float(weights(results, stage)[down].sum())
    told = [
        counted(len(down), "block"),
        f"{fallen:.3g} {unit} ({share_in_words(fallen / float(bulk[stage.present].sum()))} of all)",
    ]
    return ", ".join([*told, *([engineering(weight, results.blocks.force_unit)] if weight else [])])


def weights(results: Results, stage: StageResult) -> FloatArray:
    """Return the weight of every block (n,) [N/m], in space [N]; zeros where it is unknown.

    An earthquake's part is left out; results of a former version include it.
    """
    evidence = stage.evidence
    if evidence is not None and evidence.unit_weight is not None:
        found: FloatArray = evidence.unit_weight * results.blocks.moments.bulk
        return found
    if evidence is not None:
        return lengths(evidence.weight)
    return np.zeros(results.blocks.count) if results.model is None else results.model.weights


def _greatest_displacement(results: Results, stage: StageResult) -> str:
    """Return the greatest displacement of the blocks that do not fall."""
    rests = stage.counts
    rests[stage.unstable_blocks] = False
    if stage.unstable_blocks.size and not rests.any():
        return "not available: all blocks fall"
    greatest = engineering(float((distances(stage.displacement) * rests).max()), "m")
    told = f"{greatest} (of the other blocks)" if stage.unstable_blocks.size else greatest
    if stage.zones is None:
        return told
    return f"{engineering(stage.zones.max_displacement(rests), 'm')} at a node of the zones; mean of a block {told}"


def _water_rows(results: Results, stage: StageResult) -> list[tuple[str, str]]:
    rows = []
    if len(stage.water_table) or stage.water.any():
        total = translations(stage.water).sum(axis=0)
        name = f"of these by the water ({results.blocks.components})"
        rows.append((name, vector(total, results.blocks.force_unit)))
    if stage.flow is not None:
        rows.append(("water that flows through the joints", discharge_text(stage.flow.through)))
        rows.append(("flow", how_solved(stage.flow)))
    if stage.uplifted_blocks.size:
        rows.append(("blocks that water lifts", listing(stage.uplifted_blocks, 12)))
    return rows


def _solution_rows(results: Results, stage: StageResult) -> list[tuple[str, str]]:
    """Return how the solution was found."""
    rows = [("scheme, linear solver", f"{results.scheme}, {results.linear_solver}")]
    if results.scheme != "linear":
        spent, last = sum(step.factorizations for step in stage.steps), stage.steps[-1]
        unit = "cycles" if results.scheme == "wang" else "steps"
        rows.append((f"{unit}, factorizations", f"{len(stage.steps)}, {spent}"))
        rows.append(("open, slipping contacts", f"{last.open_contacts}, {last.slipping_contacts}"))
    return rows + balance_rows(results, stage)


def balance_rows(results: Results, stage: StageResult) -> list[tuple[str, str]]:
    """Return the number of contacts, and the greatest residual of a block as a part of the reference weight."""
    residual = f"{stage.residual:.1e} of {engineering(stage.reference_weight, results.blocks.force_unit)}"
    return [("contacts", f"{len(stage.contacts.length)}"), ("greatest unbalanced force of a block", residual)]


MOST_DOWN = 8  # blocks that are listed: the largest


def down_rows(results: Results) -> list[tuple[str, ...]]:
    """Return what ``run`` prints of the largest blocks that fall at the end."""
    stage, blocks = results.stages[-1], results.blocks
    centroid, bulk = blocks.moments.centroid, blocks.moments.bulk
    down = stage.unstable_blocks[np.argsort(-bulk[stage.unstable_blocks], kind="stable")]
    whole = float(bulk[stage.present].sum())
    weight, moved = weights(results, stage), distances(stage.displacement)
    return [
        (
            str(block),
            f"{place(centroid[block].round(2))} m",
            f"{bulk[block]:.3g} {blocks.bulk_unit}",
            engineering(float(weight[block]), blocks.force_unit),
            share_in_words(bulk[block] / whole),
            engineering(float(moved[block]), "m"),
        )
        for block in down[:MOST_DOWN].tolist()
    ]


def down_header(results: Results) -> tuple[str, ...]:
    """Return the header of `down_rows`."""
    return ("block", "at", results.blocks.bulk_name, "weight", "of all", "displacement")


def fall_header(results: Results) -> tuple[str, ...]:
    """Return the header of `fall_rows`."""
    return ("block", "stage", "from", results.blocks.bulk_name, "weight", "displacement", "reason")


def fall_rows(results: Results) -> list[tuple[str, ...]]:
    """Return what ``run`` prints of the blocks that fell and were taken away, those that count."""
    return [
        (
            str(fall.block),
            stage.name,
            f"{place(np.round(fall.origin, 2))} m",
            f"{fall.bulk:.3g} {results.blocks.bulk_unit}",
            engineering(fall.weight, results.blocks.force_unit),
            engineering(fall.moved, "m"),
            fall.reason,
        )
        for stage in results.stages
        for fall in stage.falls
        if not fall.ignored
    ]


def fall_reasons(results: Results) -> list[str]:
    """Return why blocks fell that were taken away: a line a stage and reason."""
    said: dict[tuple[str, str], list[int]] = {}
    for stage in results.stages:
        for fall in stage.falls:
            if not fall.ignored:
                said.setdefault((stage.name, fall.reason), []).append(fall.block)
    return [f"{named_stage(name)}: {numbered('block', blocks)}: {reason}" for (name, reason), blocks in said.items()]


STAGE_HEADER = ("stage", "verdict", "blocks", "in the stage", "displacement")


ZONES_HEADER = ("stage", "verdict", "blocks", "in the stage, mean of a block", "displacement of a node")


def stage_header(results: Results) -> tuple[str, ...]:
    """Return the header of `stage_rows`."""
    return STAGE_HEADER if results.stages[-1].zones is None else ZONES_HEADER


def stage_rows(results: Results) -> list[tuple[str, ...]]:
    """Return what ``run`` prints of every stage."""
    return [
        (
            stage.name,
            verdict_in_words(results.blocks, stage),
            str(int(stage.present.sum())),
            engineering(stage.max_stage_displacement, "m"),
            engineering(greatest_displacement(stage), "m"),
        )
        for stage in results.stages
    ]


def joint_header(results: Results) -> tuple[str, ...]:
    """Return the header of `joint_rows`."""
    size = "length" if results.blocks.face_unit == "m" else "area"
    return ("joint", size, "slipping", "open", "mean pressure", "shear displacement")


def joint_rows(results: Results, stage: StageResult | None = None) -> list[tuple[str, ...]]:
    """Return the use of the joint sets in a stage: without one of those that can slip, at the end of the last.

    Rock faces outside of the joints are the last row; without a stage only where they carry force.
    """
    sets = joint_sets(results, stage or results.stages[-1])
    if stage is None:
        given = () if results.model is None or results.scheme == "linear" else results.model.joints
        with_law = {joint.name for joint in given if joint.law is not None}
        sets = tuple(
            one for one in sets if one.name in with_law or (with_law and one.name == ROCK_FACE and one.pressure)
        )
    return [
        (
            one.name,
            engineering(one.length, results.blocks.face_unit),
            percent(one.slipping),
            percent(one.open),
            engineering(one.pressure, "Pa"),
            engineering(one.greatest_slip if one.greatest_slip > ROUNDING else 0.0, "m"),
        )
        for one in sets
    ]


def percent(share: float) -> str:
    """Return a share in per cent; a small share is never shown as none, nor one just below the whole as all.

    Examples
    --------
    >>> percent(-1e-16), percent(0.0001), percent(0.123), percent(1.0), percent(0.9999)
    ('0 %', '< 1 %', '12 %', '100 %', '> 99 %')
    """
    if ROUNDING < share < 0.01:
        return "< 1 %"
    return "> 99 %" if 0.99 < share < 1 - ROUNDING else f"{100 * max(share, 0.0):.0f} %"


SPREAD_HEADER = ("route", "verdict", "displacement", "differs by", "at block")


def spread_rows(ends: Sequence[RouteEnd]) -> list[tuple[str, ...]]:
    """Return what ``run --spread`` prints of every route."""
    return [
        (
            end.route,
            end.status.value,
            engineering(end.max_displacement, "m"),
            "-" if end.difference is None else engineering(end.difference, "m"),
            "-" if end.block is None else str(end.block),
        )
        for end in ends
    ]

"""Numbers of the case history of Dupont Circle Station: routes, layouts, assumptions, both readings of the bolts."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

import bsm_mesh as bsm
from bsm_mesh.converters.continuum import compare_stages
from bsm_mesh.converters.continuum.comparability import obstacle
from bsm_mesh.results.movement import verdict_in_words
from examples.dupont_station import station, sweep
from examples.numbers.pages import Table, markdown
from examples.numbers.routes import other_routes

README, PAGE = "examples/dupont_station/README.md", "docs/dupont_station.md"
OPTIONS = bsm.Options(displacement_limit=0.3)  # further is a fall: of an opening of 6 m
CASES = {"Case 1": "model", "Case 2": "bolts"}
CROWN, WALLS = (5.0, 10.0), (1.3, 2.5)  # measured [mm]
PLACES = ("crown", "left wall", "right wall")
P_I = 69.0  # kPa
Told = dict[str, object]


def told_of(results: bsm.Results) -> Told:
    """Return the record of a run: verdict, movements [mm], and pressures of the bolts [kPa]."""
    summary = station.movement_of(results).summary()
    bolts = results.stages[-1].bolts
    verdict = verdict_in_words(results.blocks, results.stages[-1])
    told = {"verdict": verdict, "settlement": summary["settlement"], "at": summary["at"]}
    for place in PLACES:
        told |= {place: summary[place].mean(), f"{place} range": (summary[place].min(), summary[place].max())}
    told["crown over walls"] = told["crown"] / ((told["left wall"] + told["right wall"]) / 2)
    greatest = bolts.greatest_force / (bolts.spacing * bolts.wall_share)
    readings = (("head", bolts.support_pressure), ("along", bolts.mean_pressure), ("greatest", greatest))
    for reading, pressure in readings:
        told[reading] = dict(zip(bolts.names, pressure / 1e3, strict=True))
    return told


@cache
def routes(case: str) -> dict[str, Told]:
    """Return what the routes of a case tell: release in parts, and other ways to the same state."""
    base = station.load(CASES[case])
    runs: dict[str, Callable[[], bsm.Results]] = {
        f"released in {parts}": lambda parts=parts: bsm.run(station.released_in(base, parts), OPTIONS)
        for parts in sweep.PARTS
    }
    runs |= dict(other_routes(base, OPTIONS))
    return {name: told_of(run()) for name, run in runs.items()}


@cache
def layouts() -> dict[str, Told]:
    """Return what Case 1 tells on the layouts that are drawn."""
    return {name: told_of(bsm.run(model, OPTIONS)) for name, model in sweep.layouts(station.load())}


def movements(told: Told) -> tuple[str, ...]:
    """Return the columns of `MOVEMENTS`."""
    numbers = (told[name] for name in ("settlement", "at", *PLACES))
    greatest = told["crown range"][1]
    settlement, at, crown, left, right = numbers
    return (told["verdict"], f"{settlement:.1f}", f"{at:.1f}", f"{crown:.1f}", f"{greatest:.1f}", *(
        f"{wall:.1f}" for wall in (left, right)))  # fmt: skip


MOVEMENTS = (
    "verdict",
    "settlement, mm",
    "at x, m",
    "crown, mean mm",
    "greatest",
    "left wall, mean mm",
    "right wall, mean mm",
)


def movement_table(what: str, rows: Iterator[tuple[str, Told]]) -> str:
    """Return a table of movements, with the least and greatest of what is at its end."""
    rows = list(rows)
    lines = [(name, *movements(told)) for name, told in rows]
    standing = [told for _, told in rows if told["verdict"] == "stable"]
    spans = [spread(told[name] for told in standing) for name in ("settlement", "at", "crown")]
    spans.append(spread(told["crown range"][1] for told in standing))
    spans += [spread(told[name] for told in standing) for name in PLACES[1:]]
    lines.append((f"range of the {len(standing)} that stand", f"{len(standing)} of {len(rows)}", *spans))
    return markdown((what, *MOVEMENTS), lines)


def spread(values: Iterator[float]) -> str:
    """Return the least and the greatest of some numbers."""
    values = list(values)
    return f"{min(values):.1f} to {max(values):.1f}" if values else "-"


def changed(variations: Callable[[bsm.Model], Iterator[tuple[str, bsm.Model]]]) -> str:
    """Return the table of one assumption after the other."""
    base = station.load()
    rows = [("as it is", routes("Case 1")["released in 4"])]
    rows += [(name, told_of(bsm.run(model, OPTIONS))) for name, model in variations(base)]
    return movement_table("changed (from)", rows)


def other_bolts() -> str:
    """Return the table of Case 2 with other bolts."""
    base = station.load("bolts")
    lines = []
    for name, model in (("as it is", base), *sweep.of_the_bolts(base)):
        told = told_of(bsm.run(model, OPTIONS))
        means = (f"{_mean(told, reading):.0f}" for reading in READINGS)
        most = (max(told[reading], key=told[reading].get) for reading in READINGS)
        lines.append((name, *movements(told), *means, *most))
    pressures = ("head, mean kPa", "along, mean kPa", "most at the head", "most along")
    return markdown(("changed (from)", *MOVEMENTS, *pressures), lines)


def methods() -> str:
    """Return the table of the README: blocks and finite elements, published and measured."""
    base = station.load()
    rows = [(f"blocks, {case}", _spans(routes(case)["released in 4"])) for case in CASES]
    for name, movement in (
        ("blocks, elastic joints (`linear`)", station.linear_blocks(base)),
        ("finite elements, elastic joints", station.continuum(base, joints=True)),
        ("finite elements, joints that slip", station.continuum(base, joints=True, slips=True, order=1)),
        ("the same, second order", station.continuum(base, joints=True, slips=True)),
        ("finite elements, no joints", station.continuum(base, joints=False)),
    ):
        rows.append((name, ("no equilibrium found", *["-"] * 4) if movement is None else _spans(_told_moved(movement))))
    lines = [(name, *spans) for name, spans in rows]
    lines += [
        ("published: BLOSMER", "10", "8", "as measured", "as measured", "as measured"),
        ("published: finite elements that slip", "4", "8", "-", "-", "-"),
        ("measured", "-", "-", "5 to 10", "1.3 to 2.5", "1.3 to 2.5"),
    ]
    return markdown(("", "greatest settlement, mm", "at x, m", "crown, mm", "left wall, mm", "right wall, mm"), lines)


def _told_moved(movement: station.Movement) -> Told:
    summary = movement.summary()
    told = {"settlement": summary["settlement"], "at": summary["at"]}
    for place in PLACES:
        told |= {place: summary[place].mean(), f"{place} range": (summary[place].min(), summary[place].max())}
    return told


def _spans(told: Told) -> tuple[str, ...]:
    ranges = (f"{told[f'{p} range'][0]:.1f} to {told[f'{p} range'][1]:.1f}, mean {told[p]:.1f}" for p in PLACES)
    return f"{told['settlement']:.1f}", f"{told['at']:.1f}", *ranges


def comparison() -> str:
    """Return what `bsm-mesh compare` says of Case 1."""
    model = station.load()
    results = bsm.run(model, OPTIONS)
    reason = obstacle(model, results, results.stages[-1])  # the finite elements need not be solved to know that
    found = f"Not comparable: {reason}." if reason else compare_stages(model, results)[-1].sentence
    return f"`bsm-mesh compare examples/dupont_station/model.toml`, stage 1: {found}"


def bolt_table() -> str:
    """Return the table of pressures of the bolts by both readings, over the routes."""
    runs = list(routes("Case 2").values())
    names = list(runs[0]["head"])
    lines = [(name, *(_pressures([told[reading][name] for told in runs]) for reading in READINGS)) for name in names]
    for side, where in SIDES.items():
        means = [[_side(told, reading, side) for told in runs] for reading in READINGS]
        lines.append((f"mean of {where}", *map(_pressures, means)))
    every = [[_mean(told, reading) for told in runs] for reading in READINGS]
    lines.append(("mean of all", *map(_pressures, every)))
    return markdown(("bolt", "at the head, kPa", "mean tension along it over the same area, kPa"), lines)


READINGS = ("head", "along")
SIDES = {"C": "the crown", "L": "the left wall", "R": "the right wall"}


def _pressures(values: Sequence[float]) -> str:
    return f"{min(values):.0f} to {max(values):.0f}"


def _mean(told: Told, reading: str) -> float:
    return float(np.mean(list(told[reading].values())))


def _side(told: Told, reading: str, side: str) -> float:
    return float(np.mean([pressure for name, pressure in told[reading].items() if name.startswith(side)]))


@dataclass(frozen=True)
class Finding:
    """Something published: what it is, in which bounds a run agrees, and what is measured of a run."""

    name: str
    published: str
    measure: Callable[[Told], float | str]
    agrees: Callable[[float | str], bool]


def between(low: float, high: float) -> Callable[[float], bool]:
    """Return whether a number lies from `low` to `high`."""
    return lambda value: low <= value <= high


def findings() -> str:
    """Return the table of what was published, and how often it comes out."""
    first, second, drawn = (list(runs.values()) for runs in (routes("Case 1"), routes("Case 2"), layouts()))
    standing = [told for told in drawn if told["verdict"] == "stable"]
    stands = Finding("the opening is stable", "yes", lambda told: told["verdict"], lambda verdict: verdict == "stable")
    lines = [_line(stands, first, drawn)]
    lines += [_line(finding, first, standing) for finding in MOVED]
    lines += [_line(finding, second, []) for finding in BOLTED]
    header = ("finding", "published", "over routes", "agrees", "over layouts by seed that stand", "agrees")
    return markdown(header, lines)


def _line(finding: Finding, *groups: Sequence[Told]) -> tuple[str, ...]:
    cells: list[str] = []
    for runs in groups:
        values = [finding.measure(told) for told in runs]
        shown = ", ".join(sorted(set(values))) if values and isinstance(values[0], str) else spread(values)
        cells += [shown, f"{sum(map(finding.agrees, values))} of {len(values)}"] if values else ["-", "-"]
    return finding.name, finding.published, *cells


MOVED = (
    Finding("greatest settlement of the top of rock, mm", "4 (finite elements), 10 (BLOSMER)",
            lambda told: told["settlement"], between(4, 10)),
    Finding("where, m right of the centre line", "about 8", lambda told: told["at"], between(6, 10)),
    Finding("crown, mean mm", "measured 5 to 10", lambda told: told["crown"], between(*CROWN)),
    Finding("left wall, mean mm", "measured 1.3 to 2.5", lambda told: told["left wall"], between(*WALLS)),
    Finding("right wall, mean mm", "measured 1.3 to 2.5", lambda told: told["right wall"], between(*WALLS)),
    Finding("crown over walls", "measured: about 4", lambda told: told["crown over walls"], between(3, 5)),
    Finding("right wall less left wall, mm", "more than 0", lambda told: told["right wall"] - told["left wall"],
            lambda mm: mm > 0),
)  # fmt: skip


def _of_bolts(reading: str, where: str) -> tuple[Finding, ...]:
    def mean(told: Told) -> float:
        return _mean(told, reading)

    def most(told: Told) -> str:
        return max(told[reading], key=told[reading].get)

    def order(told: Told) -> str:
        return " > ".join(sorted(SIDES, key=lambda side: -_side(told, reading, side)))

    return (
        Finding(f"pressure of the bolts {where}, mean kPa", "of the order of 69", mean, between(P_I / 2, 2 * P_I)),
        Finding(f"most pressure {where}", "upper right corner: C4 or R1", most, lambda name: name in ("C4", "R1")),
        Finding(f"order {where}: crown, left, right", "L least", order, lambda sides: sides.endswith("L")),
    )


BOLTED = (
    *_of_bolts("head", "at the head"),
    *_of_bolts("along", "along the bolt"),
    _of_bolts("greatest", "by the greatest tension")[1],
)


TABLES: tuple[Table, ...] = (
    Table(name="dupont-methods", page=README, make=methods, tolerance=0.02, is_slow=True),
    Table(name="dupont-findings", page=PAGE, make=findings, tolerance=0.02, is_slow=True),
    Table(name="dupont-routes", page=PAGE, make=lambda: movement_table("Case 1", routes("Case 1").items()),
          tolerance=0.02, is_slow=True),
    Table(name="dupont-routes-bolts", page=PAGE, make=lambda: movement_table("Case 2", routes("Case 2").items()),
          tolerance=0.02, is_slow=True),
    Table(name="dupont-bolts", page=PAGE, make=bolt_table, tolerance=0.02, is_slow=True),
    Table(name="dupont-compare", page=PAGE, make=comparison, tolerance=0.02, is_slow=True),
    Table(name="dupont-layouts", page=PAGE, make=lambda: movement_table("layout", layouts().items()),
          tolerance=0.02, is_slow=True),
    Table(name="dupont-ground", page=PAGE, make=lambda: changed(sweep.of_the_ground), tolerance=0.02, is_slow=True),
    Table(name="dupont-other-bolts", page=PAGE, make=other_bolts, tolerance=0.02, is_slow=True),
    Table(name="dupont-mesh", page=PAGE, make=lambda: changed(sweep.of_the_mesh), tolerance=0.02, is_slow=True),
)  # fmt: skip

"""Numbers of the case history of the Cassiar slope: routes, meshes, assumptions, Table 8.4 beside them."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Sequence
from functools import cache, partial

import numpy as np

import bsm_mesh as bsm
from examples.cassiar_slope import slope, sweep
from examples.numbers.pages import Table, markdown
from examples.numbers.routes import other_routes

README, PAGE = "examples/cassiar_slope/README.md", "docs/cassiar_slope.md"
SAME = 2e-3  # m: less water may not move it by more than this
Points = Sequence[tuple[float, float]] | None


@dataclasses.dataclass(frozen=True)
class Told:
    """What is reported of a model: its run in which the water rises, and that of weight and high water at once.

    Attributes
    ----------
    rising, at_once : str
        Verdicts.
    whole, since_dry : (conditions, 7) float64 [m]
        Displacements of the points as the water rises, from zero stress and from the dry state.
    once : (7,) float64 [m]
        Those at once.
    """

    rising: str
    at_once: str
    whole: np.ndarray
    since_dry: np.ndarray
    once: np.ndarray


def told_of(model: bsm.Model, points: Points = None) -> Told:
    """Return the record of a model."""
    rising = bsm.run(model, slope.OPTIONS)
    whole, since_dry = slope.rising(rising, points)
    once = bsm.run(slope.at_once(model), slope.OPTIONS)
    moved = slope.at_the_end(once, points)
    return Told(rising.status.value, once.status.value, whole, since_dry, moved)


@cache
def main_case() -> Told:
    """Return the record of the main case."""
    return told_of(slope.load())


@cache
def routes() -> dict[str, np.ndarray]:
    """Return the displacements of the points under high water, from zero stress, by several routes [m]."""
    base = slope.load()
    once = slope.at_once(base)
    found = {"weight and water at once": main_case().once, "the water rises": main_case().whole[-1]}
    for name, run in other_routes(once, slope.OPTIONS):
        found[f"at once, {name}"] = _standing(run())
    found["at once, the thesis's iteration"] = _standing(by_the_thesis(5000))
    return found


def by_the_thesis(cycles: int) -> bsm.Results:
    """Return the run of weight and high water at once by the thesis's iteration."""
    return bsm.run(slope.at_once(slope.load()), dataclasses.replace(slope.OPTIONS, scheme="wang", max_steps=cycles))


def at_rest() -> dict[str, np.ndarray]:
    """Return those of `routes` that reach rest."""
    return {name: points for name, points in routes().items() if not np.isnan(points).any()}


def _standing(results: bsm.Results) -> np.ndarray:
    found = slope.at_the_end(results)
    return found if results.status == "stable" else np.full_like(found, np.nan)


Variations = Callable[[bsm.Model], Iterator[tuple[str, bsm.Model, Points]]]


@cache
def varied(variations: Variations) -> dict[str, Told]:
    """Return the record of every variation."""
    return {name: told_of(model, points) for name, model, points in variations(slope.load())}


def by_routes() -> str:
    """Return the table of routes."""
    lines = [
        (name, *(["no rest"] * 7 if np.isnan(points).any() else _lengths(points)), _length(slope.from_blosmer(points)))
        for name, points in routes().items()
    ]
    return markdown(("high water, from zero stress [m]", *"1234567", "r.m.s. from BLOSMER"), lines)


def table_8_4() -> str:
    """Return Table 8.4 with the ranges over routes and meshes, how many agree, and what of them is settlement."""
    by_route = np.array(list(at_rest().values()))
    meshes = [told.once for name, told in varied(sweep.of_the_mesh).items() if name.startswith("elements")]
    by_mesh = np.array([main_case().once, *meshes])
    settled, by_water = main_case().whole[0], main_case().since_dry[-1]
    lines = []
    for k in range(7):
        told = [slope.UDEC[k], slope.BLOSMER[k], slope.OBSERVED[k]]
        published = ["-" if value is None else f"{value:.2f}" for value in told]
        known = [value for value in told if value is not None]
        ours = [cell for found in (by_route[:, k], by_mesh[:, k]) for cell in (_range(found), _within(found, known))]
        lines.append((f"{k + 1}", *published, *ours, _length(settled[k]), _length(by_water[k])))
    elements = f"over elements of {min(sweep.SIZES)} to {max(sweep.SIZES)} m"
    ours = ("range over routes", "agrees", elements, "agrees", "of it settlement: dry", "from the dry state")
    header = ("point", "UDEC", "BLOSMER", "observed", *ours)
    return markdown(header, lines)


def _within(found: np.ndarray, published: Sequence[float]) -> str:
    """Return how many lie between the least and the greatest published, rounded as these are."""
    rounded = found.round(2)
    return f"{((rounded >= min(published)) & (rounded <= max(published))).sum()} of {len(found)}"


def conditions() -> str:
    """Return the displacements of the points in the five conditions, from zero stress and from the dry state."""
    told = main_case()
    lines = [
        (condition, *(f"{a:.2f}; {b:.2f}" for a, b in zip(whole, dry, strict=True)))
        for condition, whole, dry in zip(slope.CONDITIONS, told.whole, told.since_dry, strict=True)
    ]
    return markdown(("groundwater: from zero stress; from the dry state [m]", *"1234567"), lines)


def files() -> str:
    """Return the table of the README: a line a model file."""
    lines = []
    for name, joints, what in (
        ("model", "Patton", "dry under its weight, then low, intermediate-low, intermediate and high water"),
        ("mohr_coulomb", "Mohr-Coulomb", "the same"),
        ("high_water", "Patton", "weight and high water at once from zero stress, as a run of BLOSMER"),
        ("ten_blocks", "Patton", "as model.toml, the rock between two joints one rigid block"),
    ):
        model = slope.load(name)
        results = bsm.run(model, slope.OPTIONS)
        if model.stages:
            whole, since_dry = (moved[-1, 0] for moved in slope.rising(results))
            moved = f"{whole:.2f} m", f"{since_dry:.2f} m"
        else:
            moved = f"{slope.at_the_end(results)[0]:.2f} m", "-"
        lines.append((f"{name}.toml", joints, f"{model.blocks.count}", what, results.status.value, *moved))
    header = ("file", "joints", "blocks", "what", "verdict", "point 1, from zero stress", "from the dry state")
    return markdown(header, lines)


def steps() -> str:
    """Return the table of steps and cycles to the end under high water."""
    usual = bsm.run(slope.load("high_water"), slope.OPTIONS).stages[-1]
    lines = [("UDEC", "12 500 cycles"), ("BLOSMER", "51 cycles")]
    lines.append(("here, continuation", f"{usual.status.value}, {len(usual.steps)} steps"))
    results = by_the_thesis(5000)
    told = f"{results.status.value}, {len(results.stages[-1].steps)} cycles"
    lines.append(('here, `scheme = "wang"`', f"{told}, point 1 at {slope.at_the_end(results)[0]:.2f} m"))
    return markdown(("program", "to the end under high water"), lines)


def sweep_table(variations: Variations) -> str:
    """Return the table of one assumption after the other."""
    rows = {"as it is": main_case(), **varied(variations)}
    lines = []
    for name, told in rows.items():
        points = _lengths(told.once) if told.at_once == "stable" else [told.at_once, *["-"] * 6]
        rms = _length(slope.from_blosmer(told.once)) if told.at_once == "stable" else "-"
        last = (
            (_length(told.whole[-1, 0]), _length(told.since_dry[-1, 0]))
            if told.rising == "stable"
            else (told.rising, "-")
        )
        lines.append((name, *points, rms, *last, *_marks(told)))
    header = (
        "changed (from)",
        *"1234567",
        "r.m.s. from BLOSMER",
        "1, rising",
        "1, from the dry state",
        "a b c d e, at once",
        "rising",
    )
    return markdown(header, lines)


def findings_of(told: Told) -> dict[str, str]:
    """Return the marks of `FINDINGS`, at once and as the water rises: `+` or `no`; `slides` where it is not at rest."""
    found = {}
    for way, verdict, high in (("at once", told.at_once, told.once), ("rising", told.rising, told.whole[-1])):
        holds = holding(high, told.whole[0])
        if way == "rising":
            holds["d"] = bool(
                (np.diff(told.since_dry[:, :5], axis=0) > -SAME).all() and told.since_dry[-1, :5].min() > SAME
            )
        rests = verdict == "stable"
        found |= {f"{mark}, {way}": ("+" if yes else "no") if rests else "slides" for mark, yes in holds.items()}
    return found


def holding(high: np.ndarray, dry: np.ndarray) -> dict[str, bool]:
    """Return which of `FINDINGS` hold of the points under high water and dry, both from zero stress [m]."""
    return {
        "a": bool(high[:5].min() > 2 * high[5:].max()),
        "b": bool(high.argmax() == 0),
        "c": bool((high / dry).argmax() == 4),
        "d": bool((high[:5] > dry[:5]).all()),
        "e": bool(slope.BLOSMER[0] / 2 < high[0] < 2 * slope.BLOSMER[0]),
    }


FINDINGS = (
    ("a", "the wedge moves: each of points 1 to 5 more than twice 6 and 7", "yes"),
    ("b", "point 1 moves most, from zero stress", "BLOSMER, UDEC, observed"),
    ("c", "point 5, the bottom of the wedge, feels the water most", "yes"),
    ("d", "more water, more movement of points 1 to 5", "yes"),
    ("e", "point 1 within a factor of two of 0.73 m", "0.73 (BLOSMER), 0.47 (UDEC), 0.74 m (observed)"),
)
WAYS = ("at once", "rising")


def _marks(told: Told) -> tuple[str, ...]:
    found = findings_of(told)
    return tuple(_short([found[f"{mark}, {way}"] for mark, *_ in FINDINGS]) for way in WAYS)


def _short(marks: Sequence[str]) -> str:
    return "slides" if "slides" in marks else " ".join(marks)


def findings() -> str:
    """Return the table of findings, and in how many variations each holds."""
    every = [varied(variations) for variations in (sweep.of_the_ground, sweep.of_the_section)]
    every.append({name: told for name, told in varied(sweep.of_the_mesh).items() if name.startswith("elements")})
    marks = [[findings_of(told) for told in runs.values()] for runs in every]
    base, dry = findings_of(main_case()), main_case().whole[0]
    by_route = [holding(points, dry) for points in at_rest().values()]
    lines = []
    for mark, text, published in FINDINGS:
        for way in WAYS:
            key = f"{mark}, {way}"
            rested = [[each[key] for each in runs if each[key] != "slides"] for runs in marks]
            counts = [f"{runs.count('+')} of {len(runs)}" for runs in rested]
            over = f"{sum(each[mark] for each in by_route)} of {len(by_route)}" if way == "at once" else "-"
            lines.append((f"({mark}) {text}: {way}", published, base[key], over, *counts))
    for way in WAYS:
        slides = [f"{sum(each[f'a, {way}'] == 'slides' for each in runs)} of {len(runs)}" for runs in marks]
        over = f"{len(routes()) - len(by_route)} of {len(routes())}" if way == "at once" else "-"
        lines.append((f"the wedge slides away: {way}", "in the end it did", "no", over, *slides))
    header = ("finding", "published", "main case", "routes", "other ground", "other section", "other elements")
    return markdown(header, lines)


def _length(value: float) -> str:
    return f"{value:.2f}"


def _lengths(values: np.ndarray) -> list[str]:
    return [_length(value) for value in values]


def _range(values: np.ndarray) -> str:
    return f"{values.min():.2f} to {values.max():.2f}"


TABLES: tuple[Table, ...] = (
    Table(name="cassiar-files", page=README, make=files, tolerance=0.02, is_slow=True),
    Table(name="cassiar-steps", page=README, make=steps, tolerance=0.02, is_slow=True),
    Table(name="cassiar-table-8-4", page=PAGE, make=table_8_4, tolerance=0.02, is_slow=True),
    Table(name="cassiar-findings", page=PAGE, make=findings, tolerance=0.02, is_slow=True),
    Table(name="cassiar-routes", page=PAGE, make=by_routes, tolerance=0.02, is_slow=True),
    Table(name="cassiar-conditions", page=PAGE, make=conditions, tolerance=0.02, is_slow=True),
    *(
        Table(name=f"cassiar-{name}", page=PAGE, make=partial(sweep_table, variations), tolerance=0.02, is_slow=True)
        for name, variations in (("ground", sweep.of_the_ground), ("section", sweep.of_the_section),
                                 ("mesh", sweep.of_the_mesh))
    ),
)  # fmt: skip

"""The study file read: which model, which keys vary and how, the task of every run."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import ConfigDict, Field, ValidationError

from bsm_mesh.errors import ModelError, counted, placed, raise_faults
from bsm_mesh.model.quantities import DISPLACEMENT_LIMIT
from bsm_mesh.model.quantity import Quantity, number_of
from bsm_mesh.modelfile.keys import key_parts
from bsm_mesh.modelfile.mesh_tables import PathText, Table
from bsm_mesh.modelfile.model_file import read_toml, sentences
from bsm_mesh.modelfile.model_tables import ReportTable
from bsm_mesh.modelfile.reach import Reach
from bsm_mesh.modelfile.variation import Variation
from bsm_mesh.studies.distributions import Distribution
from bsm_mesh.studies.sampling import Correlation, Method, Plan, Seeds, Source, Value, Values, make_plan
from bsm_mesh.studies.scatter import CLASSES, SCATTERING, Scatter

Answer = Literal["verdict", "movements", "factor_of_safety"]
Number = int | float | str
MOST_SEED = 2**53  # whole numbers up to it are exact in a table


class VaryTable(Table):
    """How a key varies: by a distribution, or over values that are listed, or as a running seed."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    distribution: str | None = Field(default=None, description="normal, lognormal, uniform, triangular, beta, ...")
    mean: Number | None = None
    deviation: Number | None = Field(default=None, description="standard deviation")
    mode: Number | None = None
    lower: Number | None = Field(default=None, description="least value; it cuts the distribution off")
    upper: Number | None = Field(default=None, description="greatest value")
    values: list[Number] | None = Field(default=None, min_length=1)
    first: Number | None = Field(default=None, alias="from", description="the first of `count` values, evenly spaced")
    last: Number | None = Field(default=None, alias="to")
    count: int | None = Field(default=None, ge=2, le=100_000)
    seeds: Literal[True] | None = Field(default=None, description="true: a whole number of its own for every run")


class CorrelationTable(Table):
    """Two keys whose values go together."""

    between: list[str] = Field(min_length=2, max_length=2)
    coefficient: float = Field(description="of the normal scores of both; above -1, below 1")


class ScatterTable(Table):
    """Scatter of a joint's strength from face to face."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    deviation: Number = Field(description="standard deviation of the classes")
    classes: int = Field(default=CLASSES, ge=2, le=99)


class SafetyTable(Table):
    """How the factor of safety is looked for."""

    tolerance: float = Field(default=0.005, gt=0, lt=1)
    stage: str | None = None
    joints: list[str] | None = Field(default=None, min_length=1, description="whose strength is reduced; default: all")


class StudyFile(Table):
    """A bsm-mesh study file: a model, its keys that vary, and the task of every run."""

    model: PathText = Field(description="the model file, relative to this one")
    title: str = ""
    sampling: Method = "monte_carlo"
    runs: int | None = Field(default=None, ge=1, description="of monte_carlo and latin_hypercube")
    seed: int = Field(default=1, ge=0, le=MOST_SEED)
    vary: dict[str, VaryTable] = Field(min_length=1)
    correlation: list[CorrelationTable] = Field(default_factory=list)
    scatter: dict[str, ScatterTable] = Field(default_factory=dict)
    answers: list[Answer] = Field(default=["verdict", "movements"], min_length=1)
    movement_limit: Annotated[float, DISPLACEMENT_LIMIT] | None = Field(
        default=None, description="a run that reaches rest further away counts as one that fails"
    )
    safety: SafetyTable = Field(default_factory=SafetyTable)
    report: ReportTable = Field(default_factory=ReportTable)


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Study:
    """A study as its file describes it.

    Attributes
    ----------
    path : Path
        The study file.
    file : StudyFile
        Its content.
    text : str
        Its text.
    digest : str
        SHA-256 of its content.
    variation : Variation
        The model file.
    plan : Plan
        The values of every run.
    scatters : tuple of Scatter
        What scatters from face to face.
    """

    path: Path
    file: StudyFile
    text: str
    digest: str
    variation: Variation
    plan: Plan
    scatters: tuple[Scatter, ...]

    @property
    def title(self) -> str:
        """The study's title, or the model's, or the file's name."""
        return self.file.title or self.variation.file.title or self.path.name

    @property
    def units(self) -> dict[str, str]:
        """The units of the keys that vary, empty where a key has none."""
        return {key: self.variation.unit(key) for key in self.plan.values}

    @property
    def is_drawn(self) -> bool:
        """Whether the runs are a sample of chance."""
        return self.file.sampling in ("monte_carlo", "latin_hypercube")


def load_study(path: Path, *, scripts: bool = True) -> Study:
    """Return the study of a study file.

    Parameters
    ----------
    path : Path
        The file.
    scripts : bool
        Whether its model may run a geometry script, and both may name any path.

    Raises
    ------
    ModelError
        With every fault of the file, and for faults of the model file.
    """
    content = read_toml(path, "study file")
    for table in ("vary", "scatter"):
        if isinstance(content.get(table), dict):
            content[table] = dict(flat_keys(content[table]))
    try:
        file = StudyFile.model_validate(content)
    except ValidationError as error:
        raise ModelError([f"{path.name}: {text}" for text in dict.fromkeys(sentences(error, StudyFile))]) from None
    with placed(path.name):
        model = Reach(folder=path.parent, scripts=scripts).path(file.model, "model")
    variation = Variation(model, scripts=scripts)
    with placed(path.name):
        variation.check([*file.vary, *file.scatter])
        plan = _plan(file, variation)
        _refuse_out_of_range(plan, variation)
        scatters = _scatters(file, variation)
    digest = hashlib.sha256(json.dumps(content, sort_keys=True, default=str).encode()).hexdigest()
    text = path.read_text(encoding="utf-8-sig")
    return Study(path=path, file=file, text=text, digest=digest, variation=variation, plan=plan, scatters=scatters)


def flat_keys(table: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, Any]]:
    """Return the keys of a table as whole ways: ``joint.J1.friction = {..}`` without quotes is three tables."""
    for name, value in table.items():
        part = f'"{name}"' if above and ("." in name) else name
        key = f"{above}.{part}" if above else part
        if isinstance(value, dict) and value and all(isinstance(inner, dict) for inner in value.values()):
            yield from flat_keys(value, key)
        else:
            yield key, value


def _plan(file: StudyFile, variation: Variation) -> Plan:
    faults: list[str] = []
    sources: dict[str, Source] = {}
    for key, table in file.vary.items():
        try:
            with placed(f"[vary] {key}"):
                sources[key] = _source(table, variation.quantity(key))
        except ModelError as error:
            faults.extend(error.faults)
    raise_faults(faults)
    correlations = [
        Correlation(between=(given.between[0], given.between[1]), coefficient=given.coefficient)
        for given in file.correlation
    ]
    return make_plan(sources, file.sampling, runs=file.runs, seed=file.seed, correlations=correlations)


KINDS = {
    "distribution": ("distribution",),
    "values": ("values",),
    "from": ("first", "last", "count"),
    "seeds": ("seeds",),
}
OF_DISTRIBUTION = ("mean", "deviation", "mode", "lower", "upper")


def _source(table: VaryTable, quantity: Quantity | None) -> Source:
    """Return where the values of a key come from."""
    given = [name for name, keys in KINDS.items() if any(getattr(table, key) is not None for key in keys)]
    if len(given) != 1:
        told = " and ".join(given) or "none"
        raise ModelError(f"give one of distribution, values, from (with to and count), seeds = true; given: {told}")
    stray = [name for name in OF_DISTRIBUTION if getattr(table, name) is not None and table.distribution is None]
    if stray:
        raise ModelError(f'{", ".join(stray)}: belong to a distribution; give distribution = "normal", or remove them')
    if table.seeds:
        return Seeds()
    if table.values is not None:
        return Values(tuple(_listed(table.values, quantity)))
    if table.distribution is None:
        return _spaced(table, quantity)
    if quantity is not None and quantity.whole:
        raise ModelError("is a whole number, which has no such distribution; give values = [...]")
    numbers = {name: _number(getattr(table, name), name, quantity) for name in OF_DISTRIBUTION}
    return Distribution(family=table.distribution, **numbers)


def _number(value: Number | None, name: str, quantity: Quantity | None) -> float | None:
    """Return a number of the study file in the unit of its key."""
    if value is None:
        return None
    try:
        return number_of(value, quantity)
    except ValueError as error:
        shown = f'"{value}"' if isinstance(value, str) else value
        raise ModelError(f"{name} = {shown}: {error}") from None


def _listed(values: list[Number], quantity: Quantity | None) -> Iterator[Value]:
    for value in values:
        if quantity is None or (quantity.whole and isinstance(value, int)):
            yield value
        else:
            number = _number(value, "values", quantity)
            assert number is not None
            yield number


def _spaced(table: VaryTable, quantity: Quantity | None) -> Values:
    """Return values that are evenly spaced; of whole numbers whole ones, where they are."""
    first, last = (_number(value, name, quantity) for value, name in ((table.first, "from"), (table.last, "to")))
    if first is None or last is None or table.count is None:
        raise ModelError("from, to and count go together; give all three")
    spaced = np.linspace(first, last, table.count)
    whole = all(isinstance(end, int) for end in (table.first, table.last)) and bool((spaced == np.round(spaced)).all())
    is_whole = whole and (quantity is None or quantity.whole)
    return Values(tuple(int(value) if is_whole else float(value) for value in spaced))


def _refuse_out_of_range(plan: Plan, variation: Variation) -> None:
    """Raise for keys whose values the model cannot have: many runs would come to nothing."""
    faults = []
    for key, values in plan.values.items():
        quantity = variation.quantity(key)
        if quantity is None:
            continue
        outside = [value for value in values if not isinstance(value, str) and not quantity.holds(value)]
        if outside:
            faults.append(
                f"[vary] {key}: {counted(len(outside), 'value')} of {len(values)} cannot be, the first {outside[0]:g}: "
                f"it {quantity.rule_in_file}; give lower and upper"
            )
    raise_faults(faults)


def _scatters(file: StudyFile, variation: Variation) -> tuple[Scatter, ...]:
    found, faults = [], list[str]()
    for key, table in file.scatter.items():
        parts = key_parts(key)
        if len(parts) != 3 or parts[0] != "joint" or parts[2] not in SCATTERING:
            faults.append(
                f"[scatter] {key}: only joint.NAME.friction and joint.NAME.cohesion scatter from face to face"
            )
            continue
        deviation = _number(table.deviation, f"[scatter] {key}: deviation", variation.quantity(key))
        if deviation is None or deviation <= 0:
            faults.append(f"[scatter] {key}: deviation = {deviation:g} must be above 0; leave the key out otherwise")
            continue
        found.append(Scatter(joint=parts[1], strength=parts[2], deviation=deviation, classes=table.classes))
    names = [scatter.joint for scatter in found]
    faults += [
        f"[scatter]: of joint '{name}' give friction or cohesion" for name in set(names) if names.count(name) > 1
    ]
    raise_faults(faults)
    return tuple(found)

"""Which values the keys of a model take in every run of a study: drawn, or all that are listed."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.errors import ModelError, nearest, raise_faults
from bsm_mesh.studies.distributions import Distribution

Method = Literal["monte_carlo", "latin_hypercube", "grid", "list"]
DRAWN = ("monte_carlo", "latin_hypercube")
MOST_RUNS = 1_000_000
SHOWN = 6  # digits of an eigenvalue in a message

Value: TypeAlias = float | int | str


@dataclass(frozen=True, slots=True)
class Values:
    """Values that are listed; where runs are drawn each is as likely as the others.

    Attributes
    ----------
    values : tuple of value
        At least one.
    """

    values: tuple[Value, ...]

    def at(self, probability: FloatArray) -> list[Value]:
        """Return the values at given probabilities."""
        chosen = np.minimum((probability * len(self.values)).astype(np.int64), len(self.values) - 1)
        return [self.values[k] for k in chosen]


@dataclass(frozen=True, slots=True)
class Seeds:
    """A whole number of its own for every run: the study's seed, the next one, and so on."""


Source: TypeAlias = Distribution | Values | Seeds


@dataclass(frozen=True, slots=True, kw_only=True)
class Correlation:
    """Two keys whose values go together.

    Attributes
    ----------
    between : pair of str
        The keys.
    coefficient : float
        Of the normal scores of both (a Gaussian copula): above -1, below 1.
    """

    between: tuple[str, str]
    coefficient: float


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Plan:
    """The values of every run.

    Attributes
    ----------
    values : mapping of str to list of value
        A list by key, of one value a run; all of one length.
    """

    values: Mapping[str, list[Value]]

    @property
    def count(self) -> int:
        """Number of runs."""
        return len(next(iter(self.values.values())))

    def of(self, run: int) -> dict[str, Value]:
        """Return the values of a run."""
        return {key: column[run] for key, column in self.values.items()}


def make_plan(
    sources: Mapping[str, Source],
    method: Method,
    *,
    runs: int | None = None,
    seed: int = 1,
    correlations: Sequence[Correlation] = (),
) -> Plan:
    """Return the values of every run.

    Parameters
    ----------
    sources : mapping of str to source
        Where the values of each key come from.
    method : {"monte_carlo", "latin_hypercube", "grid", "list"}
        Drawn independently; drawn so that every key's values lie evenly over its distribution; every combination of
        the listed values, the last key changing first; the first of all lists, then the second of all, and so on.
    runs : int, optional
        How many to draw; a grid and a list say it themselves.
    seed : int
        Of the random numbers. The same seed draws the same values. Of Monte Carlo the first runs are the same
        whatever their number.
    correlations : sequence of Correlation
        Between keys that are drawn.

    Raises
    ------
    ModelError
        With everything that does not fit together.
    """
    if not sources or (all(isinstance(source, Seeds) for source in sources.values()) and method not in DRAWN):
        raise ModelError("[vary] needs a key whose values are listed; a study of seeds alone is 'monte_carlo'")
    if method in DRAWN:
        values = _drawn(sources, method, _number(runs, method, sources), seed, correlations)
    else:
        raise_faults(_not_for_lists(sources, method, runs, correlations))
        listed = {key: source.values for key, source in sources.items() if isinstance(source, Values)}
        values = _grid(listed) if method == "grid" else {key: list(given) for key, given in listed.items()}
    count = len(next(iter(values.values()))) if values else int(runs or 0)
    if count > MOST_RUNS:
        raise ModelError(f"{count} runs are more than {MOST_RUNS}; take fewer values, or draw them")
    seeds: dict[str, list[Value]] = {
        key: [*range(seed, seed + count)] for key, source in sources.items() if isinstance(source, Seeds)
    }
    return Plan(values={key: seeds[key] if key in seeds else values[key] for key in sources})


def _number(runs: int | None, method: str, sources: Mapping[str, Source]) -> int:
    if runs is None or not 1 <= runs <= MOST_RUNS:
        are_listed = all(isinstance(source, Values) for source in sources.values())
        other = "; every combination of the values: sampling = 'grid'" if are_listed else ""
        raise ModelError(f"sampling = '{method}' needs the key 'runs', 1 to {MOST_RUNS}{other}")
    return runs


def _drawn(
    sources: Mapping[str, Source], method: str, runs: int, seed: int, correlations: Sequence[Correlation]
) -> dict[str, list[Value]]:
    drawn = {key: source for key, source in sources.items() if not isinstance(source, Seeds)}
    matrix = correlation_matrix(list(drawn), correlations)
    uniform = _uniform(method, runs, seed, len(drawn), matrix)
    return {
        key: list(source.at(uniform[:, k])) if isinstance(source, Values) else source.at(uniform[:, k]).tolist()
        for k, (key, source) in enumerate(drawn.items())
    }


def _uniform(method: str, runs: int, seed: int, count: int, matrix: FloatArray) -> FloatArray:
    """Return probabilities in (0, 1), (runs, count), whose normal scores have a correlation matrix."""
    from scipy.special import ndtr, ndtri
    from scipy.stats import qmc

    if count == 0:
        return np.empty((runs, 0))
    generator = np.random.default_rng(seed)
    factor = np.linalg.cholesky(matrix)
    if method == "monte_carlo":
        probability: FloatArray = ndtr(generator.standard_normal((runs, count)) @ factor.T)
    else:
        probability = qmc.LatinHypercube(count, rng=generator).random(runs)
        # Iman and Conover: values keep their strata, and take the ranks of correlated scores.
        rank = np.argsort(np.argsort(ndtri(probability) @ factor.T, axis=0, kind="stable"), axis=0, kind="stable")
        probability = np.take_along_axis(np.sort(probability, axis=0), rank, axis=0)
    tiny = np.finfo(np.float64).tiny
    return np.clip(probability, tiny, 1 - np.finfo(np.float64).epsneg)


def correlation_matrix(keys: Sequence[str], correlations: Sequence[Correlation]) -> FloatArray:
    """Return the correlation matrix of keys that are drawn, (k, k).

    Raises
    ------
    ModelError
        For keys that are not drawn, coefficients out of range, and ones that contradict each other.
    """
    matrix, faults, seen = np.eye(len(keys)), list[str](), set[frozenset[str]]()
    for given in correlations:
        unknown = [key for key in given.between if key not in keys]
        faults += [f"[[correlation]] between: '{key}' is not drawn in [vary]{nearest(key, keys)}" for key in unknown]
        if given.between[0] == given.between[1] or frozenset(given.between) in seen:
            faults.append(f"[[correlation]] between {' and '.join(given.between)}: give two keys, and each pair once")
        elif not -1 < given.coefficient < 1:
            faults.append(f"[[correlation]] coefficient = {given.coefficient:g} must be above -1 and below 1")
        elif not unknown:
            one, other = (keys.index(key) for key in given.between)
            matrix[one, other] = matrix[other, one] = given.coefficient
        seen.add(frozenset(given.between))
    raise_faults(faults)
    least = float(np.linalg.eigvalsh(matrix).min(initial=1.0))
    if least < 1e-10:
        names = sorted({key for given in correlations for key in given.between})
        raise ModelError(
            f"[[correlation]]: the coefficients between {', '.join(names)} contradict each other (their matrix is not "
            f"positive definite: its least eigenvalue is {least:.3g}); bring them nearer to 0"
        )
    return matrix


def _not_for_lists(
    sources: Mapping[str, Source], method: str, runs: int | None, correlations: Sequence[Correlation]
) -> list[str]:
    """Return settings that a grid or a list does not take, a sentence each."""
    faults = [
        f"[vary] {key}: a {method} takes values, or from, to and count, not a distribution"
        for key, source in sources.items()
        if isinstance(source, Distribution)
    ]
    if runs is not None:
        faults.append(f"runs = {runs}: a {method} has as many runs as its values say; leave it out")
    if correlations:
        faults.append(f"[[correlation]]: nothing is drawn in a {method}; leave it out")
    lengths = {key: len(source.values) for key, source in sources.items() if isinstance(source, Values)}
    if method == "list" and len(set(lengths.values())) > 1:
        told = ", ".join(f"{key}: {count}" for key, count in lengths.items())
        faults.append(f"[vary]: a list takes as many values of every key ({told}); for all combinations take a grid")
    return faults


def _grid(listed: Mapping[str, tuple[Value, ...]]) -> dict[str, list[Value]]:
    count = int(np.prod([len(values) for values in listed.values()], dtype=np.float64))
    if count > MOST_RUNS:
        raise ModelError(f"[vary]: all combinations are {count} runs, more than {MOST_RUNS}; take fewer values")
    rows = list(itertools.product(*listed.values()))
    return {key: [row[k] for row in rows] for k, key in enumerate(listed)}

"""The values compared with the histories of a run: tables of values, and other runs."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from bsm_mesh.errors import ModelError, as_given, nearest
from bsm_mesh.model.beside import Beside, faults_beside, unknown_stages
from bsm_mesh.model.stages import INITIAL
from bsm_mesh.model.values import parts_of
from bsm_mesh.reading import as_path
from bsm_mesh.results.beside import set_beside, values_of_run
from bsm_mesh.results.results import Results, Source


def with_sources(results: Results, given: Mapping[str, Source] | Sequence[Source] | Source) -> Results:
    """Return results with tables of values, or other runs, compared with their histories.

    Parameters
    ----------
    results : Results
        The result.
    given : path, Results, or several of them, or a mapping of names to them
        Tables (CSV), results folders and other results. A name says where values come from; by default a table says so
        itself, and a folder's is its own.

    Raises
    ------
    ModelError
        If a source cannot be read, or says nothing of these histories.
    """
    if not results.recorded:
        raise ModelError("nothing to compare: the run recorded no [[history]]; add them and run it again")
    if isinstance(given, str | os.PathLike | Results):
        given = [given]
    sources = parts_of(given)
    if sources is None:
        raise ModelError(
            f"plot: values for comparison = {as_given(given)} must be paths, Results, or a mapping of names to them"
        )
    named = list(given.items()) if isinstance(given, Mapping) else [("", source) for source in sources]
    for name, source in named:
        if isinstance(source, Results):
            told = name or source.title or "other run"
            values = _of_run(results, source, told, f"'{told}'")
        else:
            values = _of_path(results, as_path("beside", source), name)
        results = set_beside(results, values)
    return results


def named_source(text: str) -> tuple[str, str]:
    """Return the name and the path of ``NAME=PATH``, or a path without a name."""
    name, equals, path = text.partition("=")
    return (name.strip(), path) if equals and name.strip() and not Path(text).exists() else ("", text)


def _of_path(results: Results, path: Path, name: str) -> dict[str, tuple[Beside, ...]]:
    from bsm_mesh.converters.beside_files import read_beside
    from bsm_mesh.folder.storage import load_results

    if path.is_dir():
        return _of_run(results, load_results(path), name or path.resolve().name, str(path))
    values = read_beside(path, source=name or None)
    known = [one.name for one in results.recorded]
    stages = [stage.name for stage in results.stages]
    faults = [
        f"{path}: the run recorded no history '{history}'{nearest(history, known)}"
        for history in values
        if history not in known
    ]
    for one in results.recorded:
        here = values.get(one.name, ())
        faults += [
            f"{path}: {fault}" for fault in faults_beside(one.name, one.kind, here, max(one.distances, default=0))
        ]
        faults += [f"{path}: {fault}" for fault in unknown_stages(one.name, here, stages)]
    if faults:
        raise ModelError(faults)
    return values


def _of_run(results: Results, other: Results, source: str, place: str) -> dict[str, tuple[Beside, ...]]:
    """Return what another run finds of the same histories; points and lines need not be recorded there."""
    there = {one.name for one in other.recorded}
    values = {
        one.name: values_of_run(other, one, source)
        for one in results.recorded
        if one.name in there or one.kind == "line"
    }
    if not any(values.values()):
        raise ModelError(f"{place}: recorded none of the histories {', '.join(one.name for one in results.recorded)}")
    kept = _same_stages([stage.name for stage in results.stages], [stage.name for stage in other.stages])
    return {name: tuple(one for one in listed if kept(one.stage)) for name, listed in values.items()}


def _same_stages(ours: Sequence[str], theirs: Sequence[str]) -> Callable[[str | None], bool]:
    """Return which stages of another run, None the last one, are compared with stages of this one.

    Those of the same name, and the last with the last, unless the other run continues beyond this one's last stage.
    """
    goes_on = ours[-1] != INITIAL and ours[-1] in theirs[:-1]

    def kept(stage: str | None) -> bool:
        if stage is None:
            return not goes_on
        return stage in (ours if goes_on else ours[:-1])

    return kept

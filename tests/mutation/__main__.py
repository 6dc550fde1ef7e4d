"""``python -m tests.mutation``: a sample of mutants, the tests that concern each, and the score of every room."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Any

import click

from . import mutants
from .mutants import Mutant
from .place import KILLED, SURVIVED, TIMEOUT, Place
from .rooms import ROOMS, tests_of

Row = dict[str, Any]
COMPILING = 90.0  # processor seconds that a limit gives for kernels
BASE = 900.0  # processor seconds at most for the tests of a room, of the program as it is


@click.command()
@click.option("-n", "--size", default=100, show_default=True, help="Mutants; a larger sample begins with a smaller.")
@click.option("--seed", default=0, show_default=True, help="Of the sample.")
@click.option("--room", "rooms", multiple=True, type=click.Choice(list(ROOMS)), help="Only this one; may be repeated.")
@click.option("--folder", default="out/mutation", show_default=True, type=click.Path(path_type=Path))
@click.option("--minutes", default=float("inf"), help="Begin no further mutant after so many.")
@click.option("--again", is_flag=True, help="Try the survivors of the sample once more: new tests may kill them.")
def cli(size: int, seed: int, rooms: tuple[str, ...], folder: Path, minutes: float, again: bool) -> None:
    """Change bsm_mesh/contact and bsm_mesh/solve in one place at a time, and see whether a test fails.

    What was tried already is read from the folder, and is not tried again.
    """
    begin = time.monotonic()
    folder.mkdir(parents=True, exist_ok=True)
    files = [f for f in mutants.files() if not rooms or str(Path(f).parent.relative_to("bsm_mesh")) in rooms]
    chosen = list(islice(mutants.sample(seed, files, folder / "mutants.json"), size))
    known = _known(folder / "rows.jsonl")
    todo = [m for m in chosen if _is_open(known.get(m.key(mutants.read(m.file))), again)]
    if todo:
        place = Place(folder.resolve())
        for mutant in todo:
            if time.monotonic() - begin > 60 * minutes:
                break
            row = _try(place, mutant, _limit(place, mutant.room, files))
            known[row["key"]] = row
            with (folder / "rows.jsonl").open("a", encoding="utf-8") as file:
                file.write(json.dumps(row) + "\n")
    rows = [known[key] for m in chosen if (key := m.key(mutants.read(m.file))) in known]
    _print(rows, len(chosen))


def _known(path: Path) -> dict[str, Row]:
    lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    return {row["key"]: row for row in map(json.loads, lines)}


def _is_open(row: Row | None, again: bool) -> bool:
    return row is None or (again and row["outcome"] == SURVIVED)


def _limit(place: Place, room: str, files: list[str]) -> float:
    """Return the seconds that a mutant of a room may take, once its tests passed on the program as it is."""
    passed = place.warm_folder / "passed.json"
    known = json.loads(passed.read_text(encoding="utf-8")) if passed.exists() else {}
    if room not in known:
        known[room] = _pass(place, room, files)
        passed.write_text(json.dumps(known), encoding="utf-8")
    return COMPILING + 2 * float(known[room])


def _pass(place: Place, room: str, files: list[str]) -> float:
    tests = sorted({t for f in files if str(Path(f).parent.relative_to("bsm_mesh")) == room for t in tests_of(f)})
    ran = place.warm(tests, BASE)  # compiles too, where kernels are not there yet
    if ran.outcome != SURVIVED:
        raise click.ClickException(f"tests of {room} fail on the program as it is: {ran.failed or ran.outcome}")
    click.echo(f"{room}: {len(tests)} test files in {ran.seconds:.0f} s, kernels compiled on the way")
    return ran.seconds


def _try(place: Place, mutant: Mutant, limit: float) -> Row:
    source = mutants.read(mutant.file)
    changed = mutants.mutated(source, mutant)
    with place.mutant(mutant.file, changed):
        ran = place.run(tests_of(mutant.file), limit)
    row = {
        "key": mutant.key(source),
        "room": mutant.room,
        "file": mutant.file,
        "line": mutant.line,
        "outcome": ran.outcome,
        "seconds": round(ran.seconds, 1),
        "failed": ran.failed,
        "diff": mutants.diff(source, changed),
    }
    click.echo(f"{ran.outcome:9} {ran.seconds:5.0f} s  {mutant.file}:{mutant.line}  {ran.failed}")
    return row


def _print(rows: list[Row], size: int) -> None:
    click.echo(f"\n{len(rows)} of {size} mutants tried\n\n| room | mutants | killed | timeout | survived | score |")
    click.echo("|---|---|---|---|---|---|")
    for name, some in _by_room(rows):
        count = {outcome: sum(row["outcome"] == outcome for row in some) for outcome in (KILLED, TIMEOUT, SURVIVED)}
        numbers = " | ".join(map(str, (len(some), *count.values())))
        click.echo(f"| {name} | {numbers} | {1 - count[SURVIVED] / len(some):.0%} |")
    for row in sorted(rows, key=lambda row: (row["file"], row["line"])):
        if row["outcome"] == SURVIVED:
            click.echo(f"\n{row['file']}:{row['line']}")
            for line in row["diff"]:
                click.echo(f"    {line}")


def _by_room(rows: list[Row]) -> Iterator[tuple[str, list[Row]]]:
    for room in ROOMS:
        some = [row for row in rows if row["room"] == room]
        if some:
            yield room, some
    if rows:
        yield "all", rows


if __name__ == "__main__":
    cli(prog_name="python -m tests.mutation")

"""``python -m tests.mutation``: a sample of mutants, the tests that concern each, and the score of every room."""

from __future__ import annotations

import argparse
import json
import time
from itertools import islice
from pathlib import Path
from typing import Any

from bsm_mesh.files import write_text
from examples.numbers.pages import parted, with_between

from . import mutants
from .chosen import Watched
from .mutants import Mutant
from .place import SURVIVED, Place, Ran
from .report import markdown
from .rooms import ROOMS, tests_of

Row = dict[str, Any]
COMMAND = "python -m tests.mutation"
MARKS = f"<!-- made by {COMMAND}: begin -->", f"<!-- made by {COMMAND}: end -->"


def main() -> None:
    """Change bsm_mesh/contact and bsm_mesh/solve in one place at a time, and see whether a test fails."""
    asked = _asked()
    begin = time.monotonic()
    folder: Path = asked.folder
    folder.mkdir(parents=True, exist_ok=True)
    files = [f for f in mutants.files() if not asked.room or str(Path(f).parent.relative_to("bsm_mesh")) in asked.room]
    chosen = list(islice(mutants.sample(asked.seed, files, folder / "mutants.json"), asked.size))
    known = _known(folder / "rows.jsonl")
    todo = [m for m in chosen if _is_open(known.get(_key(m)), asked.again)]
    if todo:
        place = Place(folder.resolve())
        watched = Watched(folder, place)
    for mutant in todo:
        if time.monotonic() - begin > 60 * asked.minutes:
            break
        with (folder / "rows.jsonl").open("a", encoding="utf-8") as file:
            file.write(json.dumps(_try(place, watched, mutant)) + "\n")
    known = _known(folder / "rows.jsonl")
    rows = [known[key] for m in chosen if (key := _key(m)) in known]
    text = markdown(rows, len(chosen), asked.seed)
    if asked.into is None:
        print(text)
    else:
        write_text(asked.into, with_between(asked.into.read_text(encoding="utf-8"), MARKS, text))


def _asked() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog=COMMAND,
        description=main.__doc__,
        epilog="What was tried already is read from the folder, and is not tried again.",
    )
    parser.add_argument("-n", "--size", type=int, default=100, help="mutants (100); a larger sample begins with it")
    parser.add_argument("--seed", type=int, default=0, help="of the sample (0)")
    parser.add_argument("--room", action="append", choices=list(ROOMS), help="only this one; may be repeated")
    parser.add_argument("--folder", type=Path, default=Path("out/mutation"), help="of what was tried (out/mutation)")
    parser.add_argument("--minutes", type=float, default=float("inf"), help="begin no further mutant after so many")
    parser.add_argument("--again", action="store_true", help="try survivors once more: new tests may kill them")
    parser.add_argument("--into", type=_page, metavar="PAGE", help="a page in Markdown: what stands between its marks")
    return parser.parse_args()


def _page(given: str) -> Path:
    """Return the path of a page that has the marks: it is refused before anything is run."""
    try:
        parted(Path(given).read_text(encoding="utf-8"), MARKS)
    except (OSError, ValueError) as error:
        raise argparse.ArgumentTypeError(f"{given}: {error}") from None
    return Path(given)


def _key(mutant: Mutant) -> str:
    return mutant.key(mutants.read(mutant.file))


def _known(path: Path) -> dict[str, Row]:
    lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    known: dict[str, Row] = {}
    for row in map(json.loads, lines):
        known[row["key"]] = row | {"first": known.get(row["key"], {"first": row["outcome"]})["first"]}
    return known


def _is_open(row: Row | None, again: bool) -> bool:
    return row is None or (again and row["outcome"] == SURVIVED)


def _try(place: Place, watched: Watched, mutant: Mutant) -> Row:
    source = mutants.read(mutant.file)
    changed = mutants.mutated(source, mutant)
    ran, count = Ran(SURVIVED, 0.0), 0
    for files in tests_of(mutant.file):
        limits = watched.limits(mutant, files) if ran.outcome == SURVIVED else {}
        if limits:
            with place.mutant(mutant.file, changed):
                this = place.run(limits)
            ran, count = Ran(this.outcome, ran.seconds + this.seconds, this.failed), count + len(limits)
    row = {
        "key": mutant.key(source),
        "room": mutant.room,
        "file": mutant.file,
        "line": mutant.line,
        "outcome": ran.outcome,
        "seconds": round(ran.seconds, 1),
        "tests": count,
        "failed": ran.failed,
        "diff": mutants.diff(source, changed),
    }
    print(
        f"{ran.outcome:9} {ran.seconds:5.0f} s  {mutant.file}:{mutant.line}  {ran.failed or f'{count} tests'}",
        flush=True,
    )
    return row


if __name__ == "__main__":
    main()

"""Which lines and branches the tests reach: ``python -m tools.coverage [-n 2] [TESTS ...]``.

Runs the tests of `bootstrap.sh test` under coverage.py, processes that they start included, and prints each package and
the files that miss most. What is compiled is left out (``pragma: no cover - compiled``): coverage.py does not see it.
Exit code 1 below 95 %, or where a test fails.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from coverage import Coverage

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "out" / "coverage"
PACKAGES = ("bsm_mesh", "converters", "geometries")
LEAST = 95.0  # per cent, of each package
DAILY = "not slow and not robust and not heavy"  # as in bootstrap.sh
SHOWN = 15  # files


def run_tests(arguments: list[str], workers: int) -> int:
    """Run the tests under coverage.py; return pytest's exit code."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    for old in FOLDER.glob("data*"):
        old.unlink()
    settings = FOLDER / "settings.ini"
    sources = "\n    ".join(str(ROOT / package) for package in PACKAGES)
    settings.write_text(
        "[run]\nbranch = true\nparallel = true\npatch = subprocess\n"
        f"data_file = {FOLDER / 'data'}\nsource =\n    {sources}\n",
        encoding="utf-8",
    )
    pytest = ["-m", "pytest", "-q", "-n", str(workers), "--dist", "worksteal", "-m", DAILY, *arguments]
    command = [sys.executable, "-m", "coverage", "run", f"--rcfile={settings}", *pytest]
    environment = {**os.environ, "COVERAGE_RCFILE": str(settings)}
    failed = subprocess.run(command, cwd=ROOT, env=environment, check=False).returncode
    measured = _measured()
    measured.combine()
    measured.save()
    return failed


def _measured() -> Coverage:
    from coverage import Coverage

    return Coverage(config_file=str(FOLDER / "settings.ini"))


def report() -> int:
    """Print what was reached of each package, and the files that miss most; return the exit code."""
    measured = _measured()
    measured.load()
    measured.json_report(outfile=str(FOLDER / "coverage.json"))
    told = json.loads((FOLDER / "coverage.json").read_text(encoding="utf-8"))["files"]
    files = {Path(name): of["summary"] for name, of in told.items()}
    is_enough = True
    for package in PACKAGES:
        mine = [of for place, of in files.items() if place.parts[0] == package]
        lines, branches = (sum(of[name] for of in mine) for name in ("num_statements", "num_branches"))
        reached = sum(of["covered_lines"] + of["covered_branches"] for of in mine)
        percent = 100 * reached / max(lines + branches, 1)
        is_enough &= percent >= LEAST
        alone = 100 * sum(of["covered_branches"] for of in mine) / max(branches, 1)
        print(f"{package}: {percent:.1f} % of {lines} lines and {branches} branches; of branches alone {alone:.1f} %")
    print("\nmissing lines and branches:")
    missing = sorted(
        ((of["missing_lines"] + of["missing_branches"], place) for place, of in files.items()), reverse=True
    )
    for count, place in missing[:SHOWN]:
        print(f"{count:5d}  {files[place]['percent_covered']:5.1f} %  {place}")
    return 0 if is_enough else 1


def main() -> int:
    """Run the tests, then report."""
    parser = argparse.ArgumentParser(prog="python -m tools.coverage", description=__doc__)
    parser.add_argument("-n", "--workers", type=int, default=2)
    parser.add_argument("--report", action="store_true", help="only print the measurement before")
    parser.add_argument("tests", nargs="*", help="files or folders; by default all")
    given = parser.parse_args()
    failed = 0
    if given.report and not (FOLDER / "data").is_file():
        parser.error("nothing was measured yet; leave --report away")
    if not given.report:
        failed = run_tests(given.tests, given.workers)
        if failed:
            print(f"pytest ended with exit code {failed}: what follows is of the tests that ran", file=sys.stderr)
    return report() or int(failed != 0)


if __name__ == "__main__":
    sys.exit(main())

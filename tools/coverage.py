"""Which lines and branches the tests reach: ``python -m tools.coverage [-n 2] [--lines] [TESTS ...]``.

Runs the tests of `bootstrap.sh test` under coverage.py, processes that they start included, and prints each package and
the files that miss most. What is compiled is left out (``pragma: no cover - compiled``): coverage.py does not see it.
With `--lines`, branches are left out; from Python 3.12 on, the tests then take little longer than without coverage.py.
Exit code 1 where fewer than 95 % of the lines of a package are reached, or where a test fails.
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
LEAST = 95.0  # per cent of the lines of each package
DAILY = "not slow and not robust and not heavy"  # as in bootstrap.sh
SHOWN = 15  # files


def run_tests(arguments: list[str], workers: int, *, branches: bool = True) -> int:
    """Run the tests under coverage.py; return pytest's exit code."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    for old in FOLDER.glob("data*"):
        old.unlink()
    settings = FOLDER / "settings.ini"
    sources = "\n    ".join(str(ROOT / package) for package in PACKAGES)
    settings.write_text(
        f"[run]\nbranch = {branches}\nparallel = true\npatch = subprocess\n"
        f"data_file = {FOLDER / 'data'}\nsource =\n    {sources}\n",
        encoding="utf-8",
    )
    distributed = ["-n", str(workers), "--dist", "worksteal", "-p", "tools.coverage"]
    pytest = ["-m", "pytest", "-q", *distributed, "-m", DAILY, *arguments]
    command = [sys.executable, "-m", "coverage", "run", f"--rcfile={settings}", *pytest]
    environment = {**os.environ, "COVERAGE_RCFILE": str(settings)}
    if not branches and sys.version_info >= (3, 12):
        environment["COVERAGE_CORE"] = "sysmon"  # the interpreter's own monitoring: a line costs once
    failed = subprocess.run(command, cwd=ROOT, env=environment, check=False).returncode
    measured = _measured()
    measured.combine()
    measured.save()
    return failed


def pytest_sessionfinish() -> None:
    """Save what this process measured: pytest-xdist kills a worker that does not end soon."""
    from coverage import Coverage

    if (measuring := Coverage.current()) is not None:
        measuring.save()


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
        share = _share(mine, "covered_lines", "num_statements")
        is_enough &= share >= LEAST
        print(f"{package}: {share:.1f} % of {sum(of['num_statements'] for of in mine)} lines", end="")
        if branches := sum(of.get("num_branches", 0) for of in mine):
            print(f", {_share(mine, 'covered_branches', 'num_branches'):.1f} % of {branches} branches", end="")
        print()
    print("\nmissing lines and branches:")
    missing = sorted(
        ((of["missing_lines"] + of.get("missing_branches", 0), place) for place, of in files.items()), reverse=True
    )
    for count, place in missing[:SHOWN]:
        print(f"{count:5d}  {files[place]['percent_covered']:5.1f} %  {place}")
    return 0 if is_enough else 1


def _share(files: list[dict[str, int]], reached: str, of: str) -> float:
    """Return per cent."""
    return 100 * sum(file[reached] for file in files) / max(sum(file[of] for file in files), 1)


def main() -> int:
    """Run the tests, then report."""
    parser = argparse.ArgumentParser(prog="python -m tools.coverage", description=__doc__)
    parser.add_argument("-n", "--workers", type=int, default=2)
    parser.add_argument("--lines", action="store_true", help="leave branches out: faster")
    parser.add_argument("--report", action="store_true", help="only print the measurement before")
    parser.add_argument("tests", nargs="*", help="files or folders; by default all")
    given = parser.parse_args()
    failed = 0
    if given.report and not (FOLDER / "data").is_file():
        parser.error("nothing was measured yet; leave --report away")
    if not given.report:
        failed = run_tests(given.tests, given.workers, branches=not given.lines)
        if failed:
            print(f"pytest ended with exit code {failed}: what follows is of the tests that ran", file=sys.stderr)
    return report() or int(failed != 0)


if __name__ == "__main__":
    sys.exit(main())

"""Mutation score of a room of the engine by Cosmic Ray: ``python -m tools.mutation solve/motion --minutes 30``.

Cosmic Ray changes one operator, comparison or number at a time in a clone of the last commit, in random order, and runs
the tests of the room (docs/mutation.md). The session is kept in ``out/mutation``: the same command continues with it.

mutmut leaves decorated functions out, and its switch at run time does not reach compiled code. A mutant in the place of
a file compiles all kernels that contain it, since kernels are known by their content.
"""

from __future__ import annotations

import argparse
import os
import shlex
import sqlite3
import subprocess
import sys
import time
from pathlib import Path

import psutil
import tomli_w

ROOT = Path(__file__).parents[1]
ROOMS = {  # folders of bsm_mesh, and the test files that concern them, the fastest and most direct first
    "contact": "contact_rules history_transfer table broad_phase force_kernels stress strength corners search "
    "loop forces history own_laws in_situ verification/excavation",
    "solve/stages": "stages falls in_situ verification/excavation",
    "solve/algebra": "block_matrix constraints linear_solvers mechanisms mixed_precision loads linear supports",
    "solve/bolts": "bolt_chain bolt_forces verification/bolts verification/dowel_action verification/staged_bolts",
    "solve/linear": "linear constraints readiness stages verification/against_lagrange_multipliers",
    "solve/step": "equations forces subdomain_newton subdomain_corrections newton regularized_newton"
    " nearby_equilibrium loop",
    "solve/methods": "newton regularized_newton subdomain_newton subdomain_corrections nearby_equilibrium loop",
    "solve/motion": "motion_kernels dynamic_relaxation following loop",
    "solve/continuation": "verdict confirmed loop verification/wang_iteration verification/large_displacement",
    "solve/limit": "proof verification/limit_analysis verification/strength_factor",
}
EXCLUDED = (  # operators whose mutants fail by their type at once, or change annotations and options of compiling
    r"core/RemoveDecorator",
    r"core/ExceptionReplacer",
    r"core/ReplaceBinaryOperator_(BitOr|BitXor|LShift|RShift|Pow|FloorDiv|Mod)_",
    r"core/ReplaceBinaryOperator_\w+_(BitXor|LShift|RShift|Pow|FloorDiv|Mod)$",
    r"core/ReplaceBinaryOperator_(Add|Sub|Mul|Div)_Bit",
    r"core/ReplaceBinaryOperator_BitAnd_(Add|Sub|Mul|Div)$",
    r"core/ReplaceComparisonOperator_(Eq|NotEq|Lt|LtE|Gt|GtE)_Is",
    r"core/ReplaceUnaryOperator_(?!Delete)",
)
# Numbers of a module and of settings are chosen: their worth is measured by python -m benchmarks.campaign --set.
DROPPED = """job_id IN (SELECT job_id FROM work_results) OR job_id IN (SELECT job_id FROM mutation_specs
    WHERE definition_name IS NULL OR definition_name LIKE '%Settings' OR definition_name LIKE '%Rules')"""
SLOWER, STARTING = 5.0, 120.0  # times the tests' own time, and seconds more for kernels, that a mutant may take
QUICK = "not slow and not robust and not heavy"


def test_files(room: str) -> list[str]:
    """Return the test files that concern a room, relative to the root."""
    parts = [name.rpartition("/") for name in ROOMS[room].split()]
    return [f"tests/{folder or 'unit'}/test_{stem}.py" for folder, _, stem in parts]


def begin(folder: Path, room: str, since: str | None) -> None:
    """Clone the last commit, time the tests of a room there, and list its mutants."""
    checkout = folder / "checkout"
    subprocess.run(["git", "clone", "-q", ROOT, checkout], check=True)
    tests = ["-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "-m", QUICK, *test_files(room)]
    for _ in range(2):  # kernels are compiled at the first time
        began = time.monotonic()
        if run(folder, sys.executable, *tests):
            raise SystemExit(f"tests of {room} fail on the program as it is, in {checkout}")
    configuration = {
        "module-path": [f"bsm_mesh/{room}"],
        "excluded-modules": [],
        "timeout": STARTING + SLOWER * (time.monotonic() - began),
        "test-command": shlex.join([sys.executable, *tests]),
        "distributor": {"name": "local"},
        "filters": {"operators-filter": {"exclude-operators": EXCLUDED}, "git-filter": {"branch": f"origin/{since}"}},
    }
    (folder / "cosmic-ray.toml").write_text(tomli_w.dumps({"cosmic-ray": configuration}), encoding="utf-8")
    must(folder, "cosmic-ray", "init", "../cosmic-ray.toml", "../new.sqlite")
    must(folder, "cr-filter-operators", "../new.sqlite", "../cosmic-ray.toml")
    if since:
        must(folder, "cr-filter-git", "../new.sqlite", "--config", "../cosmic-ray.toml")
    with sqlite3.connect(folder / "new.sqlite") as session:  # mutants that filters skip would count as noticed
        session.execute(f"CREATE TEMP TABLE dropped AS SELECT job_id FROM work_items WHERE {DROPPED}")
        for table in ("work_results", "mutation_specs", "work_items"):
            session.execute(f"DELETE FROM {table} WHERE job_id IN (SELECT job_id FROM dropped)")
    session.close()
    (folder / "new.sqlite").rename(folder / "session.sqlite")


def run(folder: Path, program: str, *arguments: str, seconds: float | None = None) -> int:
    """Run a program in the clone, at most so long; return its exit code, or 0 where time was up or Ctrl-C was typed."""
    checkout = folder / "checkout"
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
    environment = {**os.environ, "PYTHONPATH": str(checkout), "PATH": path}
    process = subprocess.Popen([program, *arguments], cwd=checkout, env=environment)
    try:
        return process.wait(seconds)
    except (subprocess.TimeoutExpired, KeyboardInterrupt):
        for one in [*psutil.Process(process.pid).children(recursive=True), process]:
            one.kill()
        process.wait()
        subprocess.run(["git", "checkout", "-q", "."], cwd=checkout, check=True)  # the last mutant
        return 0


def must(folder: Path, program: str, *arguments: str) -> None:
    """Run a program in the clone, which has to succeed."""
    if run(folder, program, *arguments):
        raise SystemExit(f"{program} failed in {folder / 'checkout'}")


def main() -> None:
    """Try mutants of a room until the time is up, then print survivors and the survival rate."""
    parser = argparse.ArgumentParser(prog="python -m tools.mutation", description=__doc__)
    parser.add_argument("room", choices=list(ROOMS))
    parser.add_argument("--minutes", type=float, default=30.0, help="for mutants (30)")
    parser.add_argument("--since", metavar="BRANCH", help="only lines that differ from this branch")
    given = parser.parse_args()
    head = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=True)
    folder = ROOT / "out/mutation" / "-".join([given.room.replace("/", "-"), head.stdout.strip(), given.since or "all"])
    if not (folder / "session.sqlite").exists():
        begin(folder, given.room, given.since)
    run(folder, "cosmic-ray", "exec", "../cosmic-ray.toml", "../session.sqlite", seconds=60.0 * given.minutes)
    must(folder, "cr-report", "--surviving-only", "--show-diff", "../session.sqlite")
    print("survival rate in per cent, with its bounds at 95 % confidence:", flush=True)
    must(folder, "cr-rate", "--estimate", "../session.sqlite")


if __name__ == "__main__":
    main()

"""Run every example and check its certificates apart: ``python -m benchmarks.certificates``.

Exit code 1 where one does not hold. The check is `bsm_mesh/certificate/verify_certificate`, in a
Python that finds nothing of the package.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

ROOT = Path(__file__).parents[1]
SCRIPT = ROOT / "bsm_mesh/certificate/verify_certificate"


def checked(model: Path, place: Path) -> list[tuple[str, ...]]:
    """Return a row a stage: example, stage, verdict, ground, whether it holds, seconds of run and check, size."""
    name = f"{model.parent.name}/{model.name}"
    out, began = place / f"{model.parent.name}-{model.stem}", time.perf_counter()
    command = [sys.executable, "-m", "bsm_mesh", "run", str(model), "-o", str(out), "-q"]
    ran = subprocess.run(command, check=False, stdout=subprocess.DEVNULL)
    run, began = time.perf_counter() - began, time.perf_counter()
    if ran.returncode not in (0, 3):
        return [(name, "-", "-", "-", "no run", f"{run:.1f}", "-", "-")]
    apart = [sys.executable, "-I", str(SCRIPT), str(out)]
    done = subprocess.run(apart, check=False, capture_output=True, text=True)
    check = time.perf_counter() - began
    lines = done.stdout.splitlines()
    told = json.loads((out / "certificate.json").read_text(encoding="utf-8"))["stages"]
    rows = []
    for stage, line in zip(told, lines[-len(told) :], strict=False):
        size = (out / stage["arrays"]).stat().st_size / 1e3
        holds = "holds" if done.returncode == 0 or "DOES NOT HOLD" not in line else line
        row = name, stage["name"], stage["verdict"], stage["ground"], holds, f"{run:.1f}", f"{check:.2f}", f"{size:.0f}"
        rows.append(row)
    return rows or [(name, "-", "-", "-", "DOES NOT HOLD", f"{run:.1f}", f"{check:.2f}", "-")]


def main() -> int:
    """Run what is asked for, and print the table in Markdown."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("models", nargs="*", type=Path, help="model files; all examples by default")
    given = parser.parse_args()
    models = given.models or [
        path for path in sorted((ROOT / "examples").glob("*/*.toml")) if not path.name.startswith("study")
    ]
    print("| model | stage | verdict | ground | certificate | run s | check s | kB |")
    print("|---|---|---|---|---|---|---|---|")
    failed = 0
    with TemporaryDirectory() as place:
        for model in models:
            for row in checked(model, Path(place)):
                print(f"| {' | '.join(row)} |", flush=True)
                failed += row[4] != "holds"
    print(f"\n{failed} do not hold")
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())

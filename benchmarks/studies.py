"""A Monte Carlo study of a slope of 300 blocks: ``python -m benchmarks.studies [--runs 1000] [--kill] [--dask]``.

Told are the wall time and the share of all cores that was busy. With ``--kill`` the same study is run once more, one of
its workers and then its driver killed (signal 9), and continued with; with ``--dask`` by a local Dask cluster. Exit
code 1 where a table differs.
"""

from __future__ import annotations

import argparse
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import psutil

from bsm_mesh.folder.study_folder import RUNS
from bsm_mesh.studies.table import StudyTable

HEIGHT, BEDDING, CROSS = 40.0, 2.2, 5.0  # m: the starter's slope with 300 blocks
DIP = 15.0  # degrees, of its bedding
STUDY = """\
model = "model.toml"
title = "Slope of 300 blocks"
runs = {runs}

[vary]
joint.bedding.friction = {{ distribution = "normal", mean = 36, deviation = 3, lower = 20, upper = 50 }}
joint.J2.friction = {{ distribution = "normal", mean = 38, deviation = 3, lower = 25, upper = 50 }}

[[correlation]]
between = ["joint.bedding.friction", "joint.J2.friction"]
coefficient = 0.5
"""
DASK = """\
import sys
from pathlib import Path
from distributed import LocalCluster
from bsm_mesh.commands.study import run_study

if __name__ == "__main__":
    with LocalCluster(n_workers=int(sys.argv[2]), threads_per_worker=1, dashboard_address=None) as cluster:
        run_study(Path("study.toml"), Path(sys.argv[1]), scheduler=cluster.scheduler_address)
"""


def write_study(folder: Path, runs: int) -> None:
    """Write the model, its geometry script and the study."""
    subprocess.run([sys.executable, "-m", "bsm_mesh", "new", "slope", str(folder)], check=True, capture_output=True)
    text = (folder / "model.toml").read_text(encoding="utf-8")
    joints = f"bedding_spacing = {BEDDING}\njoint_spacing = {CROSS}"
    assert "bedding_dip = 30.0" in text
    assert "height = 20.0" in text
    text = text.replace("bedding_dip = 30.0", f"bedding_dip = {DIP}")
    text = text.replace("height = 20.0", f"height = {HEIGHT}\n{joints}")
    (folder / "model.toml").write_text(text, encoding="utf-8")
    (folder / "study.toml").write_text(STUDY.format(runs=runs), encoding="utf-8")


def answers(folder: Path) -> dict[str, Any]:
    """Return the table of a study, but for how long its runs took."""
    columns = dict(StudyTable.read(folder / "study.parquet").columns)
    del columns["seconds"]
    return columns


def study_process(folder: Path, out: str, processes: int) -> subprocess.Popen[bytes]:
    words = [sys.executable, "-m", "bsm_mesh", "study", "study.toml", "-o", out, "-q", "--processes", str(processes)]
    return subprocess.Popen(words, cwd=folder)


def finished(journal: Path) -> int:
    return journal.read_bytes().count(b'"status"') if journal.exists() else 0


def wait_for(journal: Path, count: int, driver: subprocess.Popen[bytes]) -> None:
    while finished(journal) < count and driver.poll() is None:
        time.sleep(0.05)


def run_whole(folder: Path, runs: int, processes: int) -> None:
    """Run the study, and print what it cost."""
    began, before = time.monotonic(), resource.getrusage(resource.RUSAGE_CHILDREN)
    study_process(folder, "whole", processes).wait()
    wall, after = time.monotonic() - began, resource.getrusage(resource.RUSAGE_CHILDREN)
    busy = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    verdicts = answers(folder / "whole")["status"]
    print(
        f"{runs} runs by {processes} processes: {wall:.0f} s, {busy:.0f} processor s, "
        f"{busy / wall / processes:.0%} of the cores busy; {verdicts.count('unstable')} unstable, "
        f"{verdicts.count('stable')} stable, {runs - verdicts.count('unstable') - verdicts.count('stable')} others",
        flush=True,
    )


def run_killed(folder: Path, runs: int, processes: int) -> bool:
    """Kill a worker after a third of the runs and the driver after two thirds; return whether the table is equal."""
    journal = folder / "killed" / RUNS
    driver = study_process(folder, "killed", processes)
    wait_for(journal, runs // 3, driver)
    workers = psutil.Process(driver.pid).children(recursive=True)
    workers[-1].send_signal(signal.SIGKILL)
    wait_for(journal, 2 * runs // 3, driver)
    driver.kill()
    driver.wait()
    kept = finished(journal)
    study_process(folder, "killed", processes).wait()
    equal = answers(folder / "killed") == answers(folder / "whole")
    print(
        f"a worker and the driver killed: {kept} runs kept, {finished(journal)} rows; equal table: {equal}", flush=True
    )
    return equal


def run_dask(folder: Path, processes: int) -> bool:
    """Run the study on a local Dask cluster; return whether the table is equal."""
    (folder / "by_dask.py").write_text(DASK, encoding="utf-8")
    began = time.monotonic()
    subprocess.run([sys.executable, "by_dask.py", "dask", str(processes)], cwd=folder, check=True)
    equal = answers(folder / "dask") == answers(folder / "whole")
    print(f"by Dask: {time.monotonic() - began:.0f} s; equal table: {equal}", flush=True)
    return equal


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=1000)
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--kill", action="store_true", help="kill a worker and the driver, and continue")
    parser.add_argument("--dask", action="store_true", help="by a local Dask cluster too")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "slope"
        write_study(folder, given.runs)
        run_whole(folder, given.runs, given.processes)
        equal = not given.kill or run_killed(folder, given.runs, given.processes)
        equal &= not given.dask or run_dask(folder, given.processes)
    return int(not equal)


if __name__ == "__main__":
    sys.exit(main())

"""Build and try a release as users get it: ``python -m tools.release [-o dist] [--no-install]``.

The sdist is made of the last commit when the command starts, the wheel of the sdist and of kernels compiled for this
Python, both twice: the same commit and kernels give the same bytes. Then the wheel is installed into a new environment,
with the pinned versions and no checkout, and the commands and Python blocks of the README are run.
"""

from __future__ import annotations

import argparse
import gzip
import hashlib
import io
import os
import shutil
import subprocess
import sys
import tarfile
import time
import venv
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from docs.code_blocks import TEXT, files_of, python_blocks, typed

ROOT = Path(__file__).parents[1]
SDIST = "import setuptools.build_meta as b, sys; b.build_sdist(sys.argv[1])"
KERNELS = ("-m", "bsm_mesh.commands.precompile", "--only")
WHEEL = ("-m", "pip", "wheel", "-q", "--no-deps", "--no-index", "--no-build-isolation")


def run(*command: str | Path, folder: Path, **variables: str) -> str:
    """Run a command that must succeed; return what it printed."""
    outside = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "VIRTUAL_ENV")}
    done = subprocess.run(
        command, cwd=folder, env={**outside, **variables}, capture_output=True, text=True, check=False
    )
    if done.returncode:
        raise SystemExit(f"{' '.join(map(str, command))}\n{done.stdout}{done.stderr}")
    return done.stdout


def build(folder: Path, commit: str, epoch: str, kernels: Path) -> tuple[Path, Path]:
    """Return sdist and wheel of a commit, built in an empty folder; the wheel carries compiled kernels."""
    source, made = folder / "source", folder / "made"
    for place in (source, made, folder / "unpacked"):
        place.mkdir(parents=True)
    content = subprocess.run(["git", "archive", commit], cwd=ROOT, check=True, capture_output=True).stdout
    with tarfile.open(fileobj=io.BytesIO(content)) as archive:
        archive.extractall(source, filter="fully_trusted")  # our own commit, with its links
    run(sys.executable, "-c", SDIST, made, folder=source, SOURCE_DATE_EPOCH=epoch)
    sdist = next(made.glob("*.tar.gz"))
    settle(sdist, int(epoch))
    with tarfile.open(sdist) as archive:
        archive.extractall(folder / "unpacked", filter="data")
    unpacked = next((folder / "unpacked").iterdir())
    if not kernels.is_dir():
        run(sys.executable, *KERNELS, folder=unpacked, NUMBA_CACHE_DIR=str(kernels))
    shutil.copytree(kernels, unpacked / "bsm_mesh/_kernels")
    run(sys.executable, *WHEEL, "-w", made, unpacked, folder=folder, SOURCE_DATE_EPOCH=epoch)
    return sdist, next(made.glob("*.whl"))


def settle(sdist: Path, epoch: int) -> None:
    """Write an sdist anew, without what differs from time to time and from user to user."""
    with tarfile.open(sdist) as archive:
        members = sorted(archive.getmembers(), key=lambda member: member.name)
        contents = [(member, archive.extractfile(member) if member.isfile() else None) for member in members]
        plain = io.BytesIO()
        with tarfile.open(fileobj=plain, mode="w", format=tarfile.PAX_FORMAT) as anew:
            for member, content in contents:
                member.mtime, member.uid, member.gid, member.uname, member.gname = epoch, 0, 0, "", ""
                member.mode, member.pax_headers = 0o755 if member.isdir() else 0o644, {}
                anew.addfile(member, content)
    with sdist.open("wb") as file, gzip.GzipFile("", "wb", fileobj=file, mtime=epoch) as packed:
        packed.write(plain.getvalue())


def digests(files: Sequence[Path]) -> list[str]:
    """Return the SHA-256 of files."""
    return [hashlib.sha256(file.read_bytes()).hexdigest() for file in files]


def try_readme(wheel: Path, folder: Path) -> None:
    """Install the wheel into a new environment and run there what the README shows, in an empty folder."""
    place = folder / "empty"
    place.mkdir()
    venv.create(place / ".venv", with_pip=True)
    python = place / ".venv" / "bin" / "python"
    pip = (python, "-m", "pip", "--disable-pip-version-check")
    said("installed", lambda: run(*pip, "install", "-q", "-c", ROOT / "constraints.txt", wheel, folder=place))
    said("pip check", lambda: run(*pip, "check", folder=place))
    for name, text in files_of(TEXT).items():
        (place / name).write_text(text, encoding="utf-8")
    said("commands", lambda: run("sh", "-ec", "\n".join(typed()), folder=place, PATH="/usr/local/bin:/usr/bin:/bin"))
    for number, block in enumerate(python_blocks(), start=1):
        (place / f"block_{number}.py").write_text(block, encoding="utf-8")
        said(f"Python block {number}", lambda n=number: run(python, f"block_{n}.py", folder=place))


def said(name: str, work: object) -> None:
    """Do something and say how long it took."""
    assert callable(work)
    began = time.monotonic()
    work()
    print(f"{name}: {time.monotonic() - began:.0f} s", flush=True)


def main() -> int:
    """Build twice, compare, install, run."""
    parser = argparse.ArgumentParser(prog="python -m tools.release", description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "dist")
    parser.add_argument("--no-install", action="store_true", help="build only")
    given = parser.parse_args()
    commit, epoch = run("git", "log", "-1", "--format=%H %ct", folder=ROOT).split()
    with TemporaryDirectory() as place:
        folder = Path(place)
        once, again = (build(folder / name, commit, epoch, folder / "kernels") for name in ("once", "again"))
        is_same = digests(once) == digests(again)
        given.output.mkdir(parents=True, exist_ok=True)
        for file, digest in zip(once, digests(once), strict=True):
            shutil.copy(file, given.output)
            print(f"{file.name}: {file.stat().st_size / 1e3:.0f} kB, sha256 {digest}")
        print(f"built twice: {'the same' if is_same else 'DIFFERENT'}", flush=True)
        if not given.no_install:
            try_readme(once[1], folder)
    return 0 if is_same else 1


if __name__ == "__main__":
    sys.exit(main())

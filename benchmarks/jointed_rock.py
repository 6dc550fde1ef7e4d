"""Processor seconds from joint sets to clean blocks: ``python -m benchmarks.jointed_rock [blocks ...]``.

Cut, write and read back, by kind of network; the areas are compared with that of the region.
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path

from converters import read_mesh
from geometries import Exponential, JointSet, Region, RockMass, Voronoi, cut_blocks, rectangle, write_blocks
from geometries.joint_sets import Joints

SIDE = 100.0  # m


def networks(count: int) -> dict[str, list[Joints]]:
    """Return joints for about `count` blocks in a square, by kind."""
    spacing = SIDE / count**0.5
    steep = {"dip": 107.0, "spacing": spacing}
    return {
        "two sets": [JointSet(name="J1", dip=31.3, spacing=spacing), JointSet(name="J2", **steep)],
        "scattered": [
            JointSet(name="J1", dip=31.3, spacing=Exponential(spacing), scatter=2.0),
            JointSet(name="J2", **steep, scatter=2.0),
        ],
        "ended at joints": [
            JointSet(name="J1", dip=31.3, spacing=spacing),
            JointSet(name="J2", **steep, persistence=0.7, bridge=2 * spacing, ends="t_ended"),
        ],
        "Voronoi": [Voronoi(name="V", size=spacing, rounds=2)],
    }


def measure(joints: list[Joints], folder: Path) -> str:
    """Return one line of the table."""
    mass = RockMass(regions=[Region(outline=rectangle(0, 0, SIDE, SIDE), rock="gneiss")], joints=joints, seed=1)
    start = time.process_time()
    cut = cut_blocks(mass)
    done = time.process_time()
    path = write_blocks(cut, folder / "rock.msh")
    written = time.process_time()
    blocks, _ = read_mesh(path, blocks="regions")
    end = time.process_time()
    error = abs(blocks.moments.area.sum() / SIDE**2 - 1)
    seconds = f"{done - start:8.2f}{written - done:8.2f}{end - written:8.2f}{end - start:8.2f}"
    return f"{blocks.count:9d}{seconds}{error:11.1e}"


def main(counts: list[int]) -> None:
    """Print the table."""
    print(f"{'':18}{'blocks':>9}{'cut':>8}{'write':>8}{'read':>8}{'all [s]':>8}{'area error':>11}")
    with tempfile.TemporaryDirectory() as folder:
        for count in counts:
            for kind, joints in networks(count).items():
                print(f"{kind:18}{measure(joints, Path(folder))}", flush=True)


if __name__ == "__main__":
    main([int(text) for text in sys.argv[1:]] or [10_000, 100_000])

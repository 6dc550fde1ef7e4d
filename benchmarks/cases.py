"""What is measured: a case is a scene at several sizes, and the programs that try it.

To set another Python program beside these, write a function ``(build, n, given) -> row`` as those in `programs` and
enter it here; a program of any kind joins by ``--peer NAME=COMMAND``.
"""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from inspect import signature

from benchmarks import linear, meshes
from benchmarks.measure import PARTS
from benchmarks.programs import Build, Row, run_bsm, run_command, run_limit, run_pymunk
from benchmarks.startup import COMMANDS, run_start
from tests.scenes import large

PEER = "peer"  # the entry of a command given by ``--peer``


@dataclass(frozen=True, kw_only=True)
class Case:
    """A scene and who solves it.

    Attributes
    ----------
    title : str
        What it is.
    sizes : tuple of int
        Blocks, by default.
    programs : dict of str to callable
        ``(n, given) -> row``, by name.
    parts : tuple of str
        The parts that times are split into.
    build : callable, optional
        ``n -> Scene``: what a command given by ``--peer`` gets.
    """

    title: str
    sizes: tuple[int, ...]
    programs: dict[str, Callable[[int, Namespace], Row]]
    parts: tuple[str, ...] = PARTS
    build: Callable[..., large.Scene] | None = field(default=None)

    def at_friction(self, friction: float | None) -> Case:
        """Return the case with an angle of friction [degrees] in its title; None: that of its scene."""
        if self.build is None:
            return self
        degrees = signature(self.build).parameters["friction"].default if friction is None else friction
        return replace(self, title=f"{self.title}, friction {degrees:g} degrees")


def at_rest(build: Callable[..., large.Scene], name: str = "bsm", k0: float | None = None) -> dict:
    """Return this program's entry for a scene; from zero stress, or with `k0` in situ."""
    return {name: lambda n, given: run_bsm(_with_friction(build, given), n, given, given.k0 if k0 else None)}


def _with_friction(build: Callable[..., large.Scene], given: Namespace) -> Build:
    return build if given.friction is None else partial(build, friction=given.friction)


def peers(build: Callable[..., large.Scene], *runs: Callable[[Build, int, Namespace], Row]) -> dict:
    """Return the entries of other programs for a scene."""

    def entry(run: Callable[[Build, int, Namespace], Row]) -> Callable[[int, Namespace], Row]:
        return lambda n, given: run(_with_friction(build, given), n, given)

    return {run.__name__.removeprefix("run_"): entry(run) for run in runs}


BOTH = (run_pymunk, run_limit)


def from_both_starts(build: Callable[..., large.Scene]) -> dict:
    """Return the entries of a scene in situ and with gravity switched on, and of the peers."""
    return at_rest(build, k0=1.0) | at_rest(build, "bsm-gravity") | peers(build, *BOTH)


CASES = {
    "linear": Case(
        title="Elastic ground under its weight, triangles: linear scheme, mesh in memory to stresses",
        sizes=(1000, 10_000, 100_000),
        programs={"bsm": linear.run_blocks, "scikit-fem": linear.run_fem},
        parts=("model", *PARTS),
    ),
    "wall": Case(
        title="Half-bond wall tilted by 5 degrees",
        sizes=(100, 1000, 10_000, 100_000),
        programs=at_rest(large.tilted_wall) | peers(large.tilted_wall, *BOTH),
        build=large.tilted_wall,
    ),
    "slope": Case(
        title="Slope with two joint sets; in-situ start, and gravity switched on",
        sizes=(1000, 10_000),
        programs=from_both_starts(large.jointed_slope),
        build=large.jointed_slope,
    ),
    "leaning": Case(
        title="The slope with its joint sets mirrored, so that its columns lean into it; both starts",
        sizes=(1000, 10_000),
        programs=from_both_starts(large.leaning_slope),
        build=large.leaning_slope,
    ),
    "rock": Case(
        title="Tunnel excavated in Voronoi rock under in-situ stress, cohesion 0.5 MPa",
        sizes=(1000, 10_000),
        programs=at_rest(large.blocky_rock, k0=1.0),
        build=large.blocky_rock,
    ),
    "layers": Case(
        title="Layers at 40 degrees that slide a metre to a toe (Wang's Example 3 in kind)",
        sizes=(100, 1000, 10_000),
        programs=at_rest(large.sliding_layers) | peers(large.sliding_layers, *BOTH),
        build=large.sliding_layers,
    ),
    "bolts": Case(
        title="The tilted wall with a bolt for every ten bricks",
        sizes=(1000, 10_000),
        programs=at_rest(large.tilted_wall, "no-bolts")
        | at_rest(large.bolted_wall, "passive")
        | at_rest(partial(large.bolted_wall, pretension=20e3), "pretension"),
        build=large.tilted_wall,
    ),
    "cutting": Case(
        title="From joint sets to blocks: cut, write the mesh, read it",
        sizes=(10_000,),
        programs={kind: partial(meshes.run_cutting, kind) for kind in meshes.NETWORKS},
        parts=("cut", "write", "read"),
    ),
    "files": Case(
        title="Gmsh meshes of triangles to blocks; results of the linear scheme to files and back",
        sizes=(10_000, 100_000),
        programs={
            "msh-binary": partial(meshes.run_reading, ".msh"),
            "msh-text": partial(meshes.run_reading, ".text.msh"),
            "results": meshes.run_writing,
        },
        parts=("read", "convert", "write"),
    ),
    "start": Case(
        title="A command from start to end, second use: the import, the help, and the wall of examples/tilted_wall",
        sizes=(106,),
        programs={kind: partial(run_start, kind) for kind in COMMANDS},
        parts=(),
    ),
}


def run_entry(case: Case, program: str, n: int, given: Namespace) -> Row:
    """Return the row of a program."""
    if program == PEER and case.build is not None:
        return run_command(_with_friction(case.build, given), n, given)
    return case.programs[program](n, given)

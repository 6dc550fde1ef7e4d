"""A wall on a tilted table, or a jointed slope, brought to rest: this program, pymunk and HiGHS side by side.

Run ``python -m benchmarks.wall [N ...] [--scene slope] [--programs bsm pymunk highs] [--time-limit 300]``.
Every size and program runs in a process of its own with a time limit, so that peak memory is its own; compiled code
is warmed up on a small model first, and `seconds` is the solution alone, the model being in memory.

The residual is the greatest force out of balance of a block over the mean block weight; for pymunk, which moves in
time, it is the greatest acceleration over gravity, and `drift` how far a block has moved where the springs of the
block-spring model would give micrometres. HiGHS only says whether forces within strength exist. pymunk comes with
``pip install bsm-mesh[benchmark]``.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import time

import numpy as np

import bsm_mesh as bsm
from benchmarks.scenes import DENSITY, GRAVITY, SCENES, Scene
from bsm_mesh.results.records import StepRecord

PROGRAMS = ("bsm", "pymunk", "highs")
SMALL = 100  # blocks of the model that compiled code is warmed up on
TIME_STEP, SWEEPS = 0.002, 30  # of pymunk [s]
AT_REST, SLOW, CHECK_EVERY = 1e-3, 1e-3, 20  # over gravity, m/s, steps


def run_bsm(scene: Scene, small: Scene, given: argparse.Namespace) -> dict:
    """Solve by continuation; with ``--trace`` every step is printed."""
    options = bsm.Options(scheme="continuation", linear_solver=given.solver, max_steps=given.max_steps)
    bsm.run(small.model(given.k0), options)
    began = time.perf_counter()
    model = scene.model(given.k0)
    built = time.perf_counter() - began

    def show(step: StepRecord) -> None:
        if given.trace:
            print(
                f"  step {step.step:4d}  residual {step.residual:8.1e}  moved {step.max_displacement:9.2e}  "
                f"iterations {step.newton_iterations:3d}  open {step.open_contacts:6d}  "
                f"slipping {step.slipping_contacts:6d}  {step.seconds:7.3f} s",
                file=sys.stderr,
                flush=True,
            )

    began = time.perf_counter()
    results = bsm.run(model, options, show)
    seconds = time.perf_counter() - began
    memory = peak_memory()
    stage, check = results.stages[-1], results.check()
    return {
        "blocks": model.blocks.count,
        "verdict": str(results.status),
        "note": results.linear_solver if results.status == "stable" else stage.reason,
        "residual": check.block_residual,
        "drift": stage.max_displacement,
        "steps": len(stage.steps),
        "factorizations": sum(step.factorizations for step in stage.steps),
        "seconds": seconds,
        "model": built,
        "memory": memory,
    }


def run_pymunk(scene: Scene, time_limit: float) -> dict:
    """Move the blocks in time until none accelerates, with as many sweeps a step as keep a small wall at rest."""
    import pymunk

    space = pymunk.Space()
    angle = np.radians(scene.gravity_direction)
    space.gravity = (GRAVITY * np.cos(angle), GRAVITY * np.sin(angle))
    space.iterations = SWEEPS
    centre = scene.corners.mean(axis=1)
    friction = np.tan(np.radians(scene.friction)) ** 0.5  # pymunk multiplies the two of a contact
    held = set(scene.held.tolist())
    free = []
    for k, corners in enumerate(scene.corners - centre[:, None]):
        if k in held:
            body = pymunk.Body(body_type=pymunk.Body.STATIC)
        else:
            mass = DENSITY * polygon_area(corners)
            body = pymunk.Body(mass, pymunk.moment_for_poly(mass, corners.tolist()))
            free.append(body)
        body.position = tuple(centre[k])
        shape = pymunk.Poly(body, corners.tolist())
        shape.friction = friction
        space.add(body, shape)
    start = np.array([body.position for body in free])
    began = time.perf_counter()
    velocity, acceleration, steps, verdict = np.zeros_like(start), np.inf, 0, "not_converged"
    while time.perf_counter() - began < time_limit:
        for _ in range(CHECK_EVERY - 1):
            space.step(TIME_STEP)
        before = np.array([body.velocity for body in free])
        space.step(TIME_STEP)
        velocity = np.array([body.velocity for body in free])
        acceleration = float(np.hypot(*(velocity - before).T).max()) / TIME_STEP / GRAVITY
        steps += CHECK_EVERY
        if acceleration < AT_REST and np.hypot(*velocity.T).max() < SLOW:
            verdict = "at rest"
            break
    return {
        "blocks": len(scene.corners),
        "verdict": verdict,
        "note": f"{SWEEPS} sweeps, steps of {1000 * TIME_STEP:g} ms",
        "residual": acceleration,
        "drift": float(np.hypot(*(np.array([body.position for body in free]) - start).T).max()),
        "steps": steps,
        "seconds": time.perf_counter() - began,
        "memory": peak_memory(),
    }


def run_highs(scene: Scene) -> dict:
    """Ask the linear program whether forces within strength exist in the given geometry."""
    model = scene.model()
    began = time.perf_counter()
    found = bsm.limit_analysis(model)
    return {
        "blocks": model.blocks.count,
        "verdict": "admissible" if found.admissible else "inadmissible",
        "note": "forces within strength exist" if found.admissible else "no forces within strength exist",
        "seconds": time.perf_counter() - began,
        "memory": peak_memory(),
    }


def polygon_area(corners: np.ndarray) -> float:
    x, y = corners.T
    return float(abs((x * np.roll(y, -1) - np.roll(x, -1) * y).sum()) / 2)


def peak_memory() -> float:
    """Return the peak memory of this process [GB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024**2


def in_own_process(program: str, n: int, given: argparse.Namespace) -> dict:
    """Return what a worker printed, or why there is nothing."""
    command = [sys.executable, "-m", "benchmarks.wall", str(n), "--worker", program, "--scene", given.scene]
    command += ["--friction", str(given.friction), "--solver", given.solver, "--time-limit", str(given.time_limit)]
    command += ["--max-steps", str(given.max_steps), *(["--trace"] if given.trace else [])]
    command += [] if given.k0 is None else ["--k0", str(given.k0)]
    grace = 60.0 if program != "highs" else 0.0  # to import, warm up and build the model
    try:
        done = subprocess.run(
            command,
            stdout=subprocess.PIPE,
            stderr=None if given.trace else subprocess.PIPE,
            text=True,
            check=False,
            timeout=given.time_limit + grace,
        )
    except subprocess.TimeoutExpired:
        return {"blocks": n, "verdict": "no answer", "note": f"stopped after {given.time_limit:g} s"}
    if done.returncode:
        last = ((done.stderr or "").strip().splitlines() or [f"exit code {done.returncode}"])[-1]
        return {"blocks": n, "verdict": "failed", "note": last}
    return json.loads(done.stdout.splitlines()[-1])


COLUMNS = {"residual": "9.1e", "drift": "9.2e", "steps": "6d", "factorizations": "7d", "seconds": "9.3f"}
COLUMNS |= {"model": "8.3f", "memory": "7.2f"}
HEADS = {"drift": "drift m", "factorizations": "factors", "memory": "GB"}


def print_row(program: str, row: dict) -> None:
    cells = []
    for name, form in COLUMNS.items():
        width = int(form.split(".")[0].rstrip("d"))
        cells.append(f"{row[name]:{form}}" if name in row else f"{'-':>{width}s}")
    print(f"{program:8s}{row['blocks']:8d}  {row['verdict']:14s}{'  '.join(cells)}  {row['note']}", flush=True)


def print_head() -> None:
    cells = [f"{HEADS.get(name, name):>{int(form.split('.')[0].rstrip('d'))}s}" for name, form in COLUMNS.items()]
    print(f"{'program':8s}{'blocks':>8s}  {'verdict':14s}{'  '.join(cells)}  note", flush=True)


def work(given: argparse.Namespace) -> dict:
    n, make = int(given.sizes[0]), SCENES[given.scene]
    scene = make(n, given.friction)
    if given.worker == "bsm":
        return run_bsm(scene, make(SMALL, given.friction), given)
    return run_pymunk(scene, given.time_limit) if given.worker == "pymunk" else run_highs(scene)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("sizes", nargs="*", type=float, default=[100, 1000, 10_000, 100_000])
    parser.add_argument("--scene", choices=tuple(SCENES), default="wall")
    parser.add_argument("--programs", nargs="+", choices=PROGRAMS, default=PROGRAMS)
    parser.add_argument("--friction", type=float, default=35.0, help="degrees")
    parser.add_argument(
        "--k0", type=float, help="the slope starts with this stress ratio in situ, not from zero stress"
    )
    parser.add_argument("--max-steps", type=int, default=500, help="of bsm")
    parser.add_argument("--solver", default="auto", help="linear solver of bsm")
    parser.add_argument("--time-limit", type=float, default=300.0, help="seconds for every worker")
    parser.add_argument("--trace", action="store_true", help="print every step of bsm")
    parser.add_argument("--worker", choices=PROGRAMS, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.k0 is not None and given.scene != "slope":
        parser.error("--k0 belongs to --scene slope: a wall has no ground")
    if given.worker:
        print(json.dumps(work(given)))
        return
    print_head()
    for size in given.sizes:
        for program in given.programs:
            print_row(program, in_own_process(program, int(size), given))


if __name__ == "__main__":
    main()

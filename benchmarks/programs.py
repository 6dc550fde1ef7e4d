"""The programs that bring a scene to rest: this one, pymunk, and any other through a command; and limit analysis.

Each returns a row: ``blocks``, ``verdict``, ``note``, ``seconds`` of the solution with the model in memory, and what
else it can tell of ``residual``, ``drift``, ``steps``, ``factorizations``, ``parts``, ``processor``, ``memory``. The
residual is the largest residual force of a block over the mean block weight; of pymunk, which moves in time, the
greatest acceleration over gravity. Drift is how far a block moved, where the springs of the block-spring model
would give micrometres.
"""

from __future__ import annotations

import json
import resource
import shlex
import subprocess
import sys
import tempfile
import time
from argparse import Namespace
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import bsm_mesh as bsm
from benchmarks.measure import Split, peak_memory
from bsm_mesh.results.records import StepRecord
from tests.scenes.large import DENSITY, GRAVITY, STIFFNESS, Scene

Row = dict[str, Any]
Build = Callable[[int], Scene]
SMALL = 100  # blocks of the model that compiled code is warmed up on
TIME_STEP, SWEEPS = 0.002, 30  # of pymunk [s]: as many sweeps as keep a small wall at rest
AT_REST, SLOW, CHECK_EVERY = 1e-3, 1e-3, 20  # over gravity, m/s, steps


def run_bsm(build: Build, n: int, given: Namespace, k0: float | None = None) -> Row:
    """Solve by continuation; with ``--trace`` every step is printed."""
    options = bsm.Options(
        scheme="continuation", linear_solver=given.solver, threads=given.threads, max_steps=given.max_steps
    )
    bsm.run(build(SMALL).model(k0), options)
    model, split = build(n).model(k0), Split()
    with split.watch():
        results = bsm.run(model, options, show if given.trace else None)
    memory = peak_memory()
    stage, check = results.stages[-1], results.check()
    return {
        "blocks": model.blocks.count,
        "verdict": str(results.status),
        "note": results.linear_solver if results.status == "stable" else stage.reason,
        "residual": check.block_residual,
        "drift": stage.max_displacement,
        "steps": sum(len(stage.steps) for stage in results.stages),
        "factorizations": sum(step.factorizations for stage in results.stages for step in stage.steps),
        "seconds": split.total,
        "processor": split.processor,
        "parts": split.seconds,
        "memory": memory,
    }


def show(step: StepRecord) -> None:
    """Print an accepted step on stderr."""
    print(
        f"  step {step.step:4d}  residual {step.residual:8.1e}  moved {step.max_displacement:9.2e}  "
        f"iterations {step.newton_iterations:3d}  open {step.open_contacts:6d}  "
        f"slipping {step.slipping_contacts:6d}  {step.seconds:7.3f} s",
        file=sys.stderr,
        flush=True,
    )


def run_pymunk(build: Build, n: int, given: Namespace) -> Row:
    """Move the blocks in time until none accelerates."""
    import pymunk

    scene = build(n)
    space = pymunk.Space()
    angle = np.radians(scene.gravity_direction)
    space.gravity = (GRAVITY * np.cos(angle), GRAVITY * np.sin(angle))
    space.iterations = SWEEPS
    friction = np.tan(np.radians(scene.friction)) ** 0.5  # pymunk multiplies the two of a contact
    held, free = set(scene.held.tolist()), []
    for k, polygon in enumerate(scene.polygons):
        centre = polygon.mean(axis=0)
        corners = polygon - centre
        if k in held:
            body = pymunk.Body(body_type=pymunk.Body.STATIC)
        else:
            mass = DENSITY * polygon_area(corners)
            body = pymunk.Body(mass, pymunk.moment_for_poly(mass, corners.tolist()))
            free.append(body)
        body.position = tuple(centre)
        shape = pymunk.Poly(body, corners.tolist())
        shape.friction = friction
        space.add(body, shape)
    start = np.array([body.position for body in free])
    began, work = time.perf_counter(), time.process_time()
    acceleration, steps, verdict = np.inf, 0, "not_converged"
    while time.perf_counter() - began < given.time_limit:
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
        "blocks": len(scene.polygons),
        "verdict": verdict,
        "note": f"{SWEEPS} sweeps, steps of {1000 * TIME_STEP:g} ms",
        "residual": acceleration,
        "drift": float(np.hypot(*(np.array([body.position for body in free]) - start).T).max()),
        "steps": steps,
        "seconds": time.perf_counter() - began,
        "processor": time.process_time() - work,
        "memory": peak_memory(),
    }


def polygon_area(corners: np.ndarray) -> float:
    """Return the area of a polygon (k, 2)."""
    x, y = corners.T
    return float(abs((x * np.roll(y, -1) - np.roll(x, -1) * y).sum()) / 2)


def run_limit(build: Build, n: int, given: Namespace) -> Row:
    """Ask limit analysis whether forces within strength exist in the given geometry; it says no more."""
    model = build(n).model()
    began, work = time.perf_counter(), time.process_time()
    found = bsm.limit_analysis(model)
    return {
        "blocks": model.blocks.count,
        "verdict": "admissible" if found.admissible else "inadmissible",
        "note": "forces within strength exist" if found.admissible else "no forces within strength exist",
        "seconds": time.perf_counter() - began,
        "processor": time.process_time() - work,
        "memory": peak_memory(),
    }


def run_command(build: Build, n: int, given: Namespace) -> Row:
    """Give the scene to a command (``--peer NAME=COMMAND``) as a JSON file, and read its row from its last line.

    The file holds ``polygons``, ``held``, ``friction`` [degrees], ``cohesion`` [Pa], ``gravity`` [m/s2],
    ``gravity_direction`` [degrees], ``density`` [kg/m3], ``stiffness`` [Pa/m] and ``time_limit`` [s]; its path is the
    command's last argument.
    """
    scene = build(n)
    content = {
        "polygons": [np.asarray(polygon).tolist() for polygon in scene.polygons],
        "held": scene.held.tolist(),
        "friction": scene.friction,
        "cohesion": scene.cohesion,
        "gravity": GRAVITY,
        "gravity_direction": scene.gravity_direction,
        "density": DENSITY,
        "stiffness": STIFFNESS,
        "time_limit": given.time_limit,
    }
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scene.json"
        path.write_text(json.dumps(content), encoding="utf-8")
        began = time.perf_counter()
        done = subprocess.run([*shlex.split(given.command), str(path)], capture_output=True, text=True, check=False)
        seconds = time.perf_counter() - began
    if done.returncode:
        raise RuntimeError((done.stderr.strip().splitlines() or [f"exit code {done.returncode}"])[-1])
    memory = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024**2
    return {
        "blocks": len(scene.polygons),
        "seconds": seconds,
        "memory": memory,
        **json.loads(done.stdout.splitlines()[-1]),
    }

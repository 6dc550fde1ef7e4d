"""The linear program of limit analysis by several solvers: ``python -m benchmarks.limit_solvers``.

Every solver is handed the same matrices, those of what strength lacks in a slope or a wall, on one thread. Printed are
processor seconds, and by how much the least cost differs from Clarabel's. HiGHS is asked through SciPy, as limit
analysis once did, and through highspy, if that is installed.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from unittest.mock import patch

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import csc_array, vstack

from bsm_mesh.solve.algebra.loads import external_loads
from bsm_mesh.solve.limit import program as limit_program
from bsm_mesh.solve.limit.interior_point import minimise
from bsm_mesh.solve.limit.strength_factor import strength_limit
from tests.scenes.large import Scene, jointed_slope, tilted_wall

SIZES = 100, 400, 1000, 2400
SCENES: dict[str, Callable[[int], Scene]] = {"slope": jointed_slope, "wall": tilted_wall}
Program = tuple  # cost, balance, right, bounded, bound, as `minimise` takes them
Cost = float | str


def asked(scene: Scene) -> Program:
    """Return the linear program of what the contacts lack."""
    model, kept = scene.model().replace(contact_points="ends"), []

    def keep(*given):
        kept.append(given)
        return minimise(*given)

    with patch.object(limit_program, "minimise", keep):
        limit_program.LimitProgram(model).balance(external_loads(model))
    return kept[0]


def by_clarabel(program: Program, limit: float) -> Cost:
    return float(program[0] @ minimise(*program).x)


def by_scipy(program: Program, limit: float) -> Cost:
    cost, balance, right, bounded, bound = program
    given = {"A_eq": balance, "b_eq": right, "A_ub": bounded, "b_ub": bound, "bounds": (None, None)}
    found = linprog(cost, **given, method="highs-ipm", options={"time_limit": limit})
    return float(found.fun) if found.status == 0 else found.message


def by_highs(program: Program, limit: float, **options: str) -> Cost:
    import highspy

    cost, balance, right, bounded, bound = program
    matrix, free = csc_array(vstack([balance, bounded])), np.full(len(cost), np.inf)
    solver, problem = highspy.Highs(), highspy.HighsLp()
    for name, value in {"output_flag": False, "threads": 1, "time_limit": limit, **options}.items():
        solver.setOptionValue(name, value)
    problem.num_col_, problem.num_row_ = len(cost), matrix.shape[0]
    problem.col_cost_, problem.col_lower_, problem.col_upper_ = cost, -free, free
    problem.row_lower_ = np.concatenate([right, np.full(len(bound), -np.inf)])
    problem.row_upper_ = np.concatenate([right, bound])
    problem.a_matrix_.format_ = highspy.MatrixFormat.kColwise
    problem.a_matrix_.start_, problem.a_matrix_.index_ = matrix.indptr, matrix.indices
    problem.a_matrix_.value_ = matrix.data
    solver.passModel(problem)
    solver.run()
    status = solver.getModelStatus()
    solved = status == highspy.HighsModelStatus.kOptimal
    return float(solver.getInfo().objective_function_value) if solved else solver.modelStatusToString(status)


SOLVERS: dict[str, tuple[Callable[..., Cost], dict[str, str]]] = {
    "Clarabel, multipliers to rounding": (by_clarabel, {}),
    "SciPy's HiGHS, interior point": (by_scipy, {}),
    "HiGHS, interior point, no crossover": (by_highs, {"solver": "ipm", "run_crossover": "off"}),
    "HiGHS, HiPO, no crossover": (by_highs, {"solver": "hipo", "run_crossover": "off"}),
    "HiGHS, PDLP": (by_highs, {"solver": "pdlp"}),
    "HiGHS, simplex": (by_highs, {"solver": "simplex"}),
}


def main() -> None:
    """Print a table a scene and size."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sizes", type=int, nargs="+", default=SIZES, metavar="N")
    parser.add_argument("--scene", nargs="+", choices=SCENES, default=list(SCENES))
    parser.add_argument("--time-limit", type=float, default=200.0, metavar="SECONDS", help="a solver, of wall time")
    given = parser.parse_args()
    for name in given.scene:
        for n in given.sizes:
            scene = SCENES[name](n)
            program = asked(scene)
            print(f"{name}: {len(scene.polygons)} blocks, {len(program[0])} unknowns, {len(program[4])} bounds")
            least = None
            for solver, (solve, options) in SOLVERS.items():
                began = time.process_time()
                try:
                    cost = solve(program, given.time_limit, **options)
                except ImportError:
                    cost = "highspy is not installed"
                seconds = time.process_time() - began
                least = cost if least is None else least
                told = cost if isinstance(cost, str) else f"{cost:.9f} ({cost - least:+.1e})"
                print(f"    {solver:36}{seconds:9.2f} s   {told}", flush=True)
            began = time.process_time()
            found = strength_limit(scene.model())
            seconds = time.process_time() - began
            print(f"    factor of strength {found.factor:.6g} by {found.programs} programs{seconds:9.2f} s", flush=True)


if __name__ == "__main__":
    main()

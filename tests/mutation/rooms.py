"""Which tests concern a file: those that import it, then those of its room."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from .mutants import ROOT

ROOMS = {
    "contact": "search contact_rules history_transfer corners broad_phase strength table force_kernels stress loop",
    "solve": "values",
    "solve/stages": "stages falls in_situ verification/excavation",
    "solve/algebra": "block_matrix constraints linear_solvers mechanisms mixed_precision linear supports loads",
    "solve/bolts": "bolt_chain bolt_forces verification/bolts verification/dowel_action verification/staged_bolts",
    "solve/contacts": "force_kernels forces history history_transfer in_situ own_laws loop verification/excavation",
    "solve/linear": "linear constraints readiness stages verification/against_lagrange_multipliers",
    "solve/step": "forces subdomain_newton subdomain_corrections newton regularized_newton nearby_equilibrium loop",
    "solve/methods": "newton regularized_newton nearby_equilibrium subdomain_newton subdomain_corrections loop",
    "solve/motion": "motion_kernels relaxation following loop",
    "solve/continuation": "loop verdict confirmed verification/wang_iteration verification/large_displacement",
    "solve/limit": "proof verification/limit_analysis verification/strength_factor",
}
LEFT_OUT = {"add_a_method", "bad_places", "compiled", "heap", "pardiso_mpi"}  # slow, or of other things


def tests_of(file: str) -> list[str]:
    """Return the test files for a file, those first that import it."""
    module = file.removesuffix(".py").replace("/", ".")
    importing = [name for name, text in _unit_tests().items() if f"{module} import" in text]
    package, _, stem = module.rpartition(".")
    importing += [name for name, text in _unit_tests().items() if f"from {package} import {stem}" in text]
    room = [_path(name) for name in ROOMS[str(Path(file).parent.relative_to("bsm_mesh"))].split()]
    return list(dict.fromkeys([*importing, *(name for name in room if (ROOT / name).exists())]))


@cache
def _unit_tests() -> dict[str, str]:
    paths = sorted((ROOT / "tests/unit").glob("test_*.py"))
    kept = [path for path in paths if path.stem.removeprefix("test_") not in LEFT_OUT]
    return {str(path.relative_to(ROOT)): path.read_text(encoding="utf-8") for path in kept}


def _path(name: str) -> str:
    folder, _, stem = name.rpartition("/")
    return f"tests/{folder or 'unit'}/test_{stem}.py"

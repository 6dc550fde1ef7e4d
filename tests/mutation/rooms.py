"""Which tests concern a file: those that import it, then those of its room."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

from .mutants import ROOT

ROOMS = {  # the most direct before the bar
    "contact": "search contact_rules history_transfer corners broad_phase | strength table force_kernels stress loop",
    "solve": "values",
    "solve/stages": "stages falls in_situ | verification/excavation",
    "solve/algebra": "block_matrix constraints linear_solvers mechanisms mixed_precision loads | linear supports",
    "solve/bolts": "bolt_chain bolt_forces | verification/bolts verification/dowel_action verification/staged_bolts",
    "solve/contacts": "force_kernels forces history history_transfer own_laws | in_situ loop verification/excavation",
    "solve/linear": "linear constraints readiness | stages verification/against_lagrange_multipliers",
    "solve/step": "forces subdomain_newton subdomain_corrections newton regularized_newton | nearby_equilibrium loop",
    "solve/methods": "newton regularized_newton nearby_equilibrium subdomain_newton subdomain_corrections | loop",
    "solve/motion": "motion_kernels relaxation | following loop",
    "solve/continuation": "loop verdict confirmed | verification/wang_iteration verification/large_displacement",
    "solve/limit": "proof verification/limit_analysis | verification/strength_factor",
}
LEFT_OUT = {"add_a_method", "bad_places", "compiled", "heap", "mutation"}  # slow, or of other things


def tests_of(file: str) -> list[list[str]]:
    """Return the test files for a file, in groups: those that import it, then the others of its room."""
    package, _, stem = file.removesuffix(".py").replace("/", ".").rpartition(".")
    imports = re.compile(rf"from {package}\.{stem} import|from {package} import .*\b{stem}\b")
    importing = [name for name, text in _unit_tests().items() if imports.search(text)]
    room = str(Path(file).parent.relative_to("bsm_mesh"))
    paths = [[_path(name) for name in group.split()] for group in ROOMS[room].split(" | ")]
    return [
        importing,
        *([name for name in group if name not in importing and (ROOT / name).exists()] for group in paths),
    ]


@cache
def _unit_tests() -> dict[str, str]:
    paths = sorted((ROOT / "tests/unit").glob("test_*.py"))
    kept = [path for path in paths if path.stem.removeprefix("test_") not in LEFT_OUT]
    return {str(path.relative_to(ROOT)): path.read_text(encoding="utf-8") for path in kept}


def _path(name: str) -> str:
    folder, _, stem = name.rpartition("/")
    return f"tests/{folder or 'unit'}/test_{stem}.py"

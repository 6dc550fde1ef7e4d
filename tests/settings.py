"""The numeric settings of the solver, each with what it is: ``python -m tests.settings`` prints and counts them.

A setting is a number that somebody chose: a field of a ``...Settings`` dataclass, a constant of a module, or a number
that a constant made of such a class is given. What only names a format or represents infinity is none, nor are the
options of a run, which users choose.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

SOLVER = Path(__file__).parents[1] / "bsm_mesh" / "solve"
FORCES = ("closure", "contact_set", "force_kernels", "forces", "history", "in_situ", "stage_transfer", "tangents")
FORMATS = {  # numbers of libraries and of layouts, and stand-ins for infinity
    "algebra/pardiso.py": {
        "ANALYSE",
        "FACTORIZE",
        "SOLVE",
        "RELEASE",
        "_POSITIVE_DEFINITE",
        "_STRUCTURALLY_SYMMETRIC",
    },
    "zones/joint_points.py": {"LINEAR"},  # an exact integral
    "zones/hoek_brown.py": {"CIRCLES"},  # signs
    "zones/mohr_coulomb.py": {"SETS"},  # of planes
    "limit/program.py": {"SOLVED", "INFEASIBLE", "UNBOUNDED"},
    "motion/contact_columns.py": {"WIDTH"},
    "motion/meeting.py": {"ARRIVED", "GIVEN_UP", "THREADS"},
    "motion/window_columns.py": {"UNLIMITED", "HIGH"},
}


@dataclass(frozen=True)
class Setting:
    """A number that somebody chose: where, its name and value, and what the code says of it."""

    place: str
    name: str
    value: str
    explained: str


def settings_of(source: str, place: str) -> Iterator[Setting]:
    """Return the settings of a source text."""
    lines = source.splitlines()
    for node in ast.parse(source).body:
        if isinstance(node, ast.ClassDef) and node.name.endswith("Settings"):
            told = ast.get_docstring(node) or ""
            for field in node.body:
                if isinstance(field, ast.AnnAssign) and field.value is not None:
                    name = f"{node.name}.{ast.unparse(field.target)}"
                    said = _of_attribute(told, ast.unparse(field.target))
                    yield from (Setting(place, name, value, said) for value in _numbers(field.value))
        if isinstance(node, ast.Assign) and _is_upper(names := ast.unparse(node.targets[0])):
            said = _comment(lines, node)
            for name, part in _assigned(names, node.value):
                if name not in FORMATS.get(place, ()):
                    yield from (Setting(place, name, value, said) for value in _numbers(part))


def _is_upper(names: str) -> bool:
    return names.replace("_", "").replace(",", "").strip("()").replace(" ", "").isupper()


def _assigned(names: str, value: ast.expr) -> list[tuple[str, ast.expr]]:
    """Return what is assigned, name by name."""
    several = names.strip("()").split(", ")
    if len(several) > 1 and isinstance(value, ast.Tuple):
        return list(zip(several, value.elts, strict=True))
    return [(names, value)]


def _numbers(value: ast.expr) -> list[str]:
    """Return the numbers that a value sets: none in names of others, as many as there are in a tuple or a call."""
    if isinstance(value, ast.Constant):
        return [ast.unparse(value)] if type(value.value) in (int, float) else []
    if isinstance(value, ast.UnaryOp | ast.BinOp):
        return (
            [ast.unparse(value)]
            if any(type(getattr(n, "value", None)) in (int, float) for n in ast.walk(value))
            else []
        )
    if isinstance(value, ast.Tuple):
        return [number for part in value.elts for number in _numbers(part)]
    if isinstance(value, ast.Call) and ast.unparse(value.func).endswith("Settings"):
        return [f"{word.arg}={number}" for word in value.keywords for number in _numbers(word.value)]
    return []


def _of_attribute(docstring: str, name: str) -> str:
    """Return what the section of attributes says of one."""
    said, own = [], False
    for line in docstring.partition("Attributes\n----------\n")[2].splitlines():
        if line and not line.startswith(" "):
            own = name in [word.strip() for word in line.partition(" : ")[0].split(",")]
            said += [line.partition(" : ")[2]] if own else []
        elif own:
            said.append(line.strip())
    return " ".join(said)


def _comment(lines: list[str], node: ast.Assign) -> str:
    """Return the comment behind a statement, else the one above it."""
    behind = lines[(node.end_lineno or 0) - 1].partition("  # ")[2]
    if behind:
        return behind
    above, k = [], node.lineno - 2
    while k >= 0 and lines[k].startswith("# "):
        above.insert(0, lines[k][2:])
        k -= 1
    return " ".join(above)


@cache
def solver_settings() -> list[Setting]:
    """Return the settings of the solver."""
    files = [(path, path.relative_to(SOLVER).as_posix()) for path in sorted(SOLVER.rglob("*.py"))]
    files += [(SOLVER.parent / "contact" / f"{name}.py", f"contact/{name}.py") for name in FORCES]
    return [setting for path, place in files for setting in settings_of(path.read_text(encoding="utf-8"), place)]


if __name__ == "__main__":
    known = solver_settings()
    for setting in known:
        print(f"{setting.place:32} {setting.name:40} {setting.value:18} {setting.explained}")
    print(f"{len(known)} settings")

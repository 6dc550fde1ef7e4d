"""Shared rooms know no dimension: how many numbers a block has, x and y, areas and outlines they ask the blocks."""

import ast
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[2] / "bsm_mesh"
SHARED = [  # folders and files, without those of `OF_THE_PLANE`
    "run.py",
    "safety",
    "studies",
    "solve/methods",
    "solve/continuation",
    "solve/stages",
    *(f"solve/step/{name}.py" for name in ("system", "equations", "subproblem", "factorization", "attempt")),
    *(f"solve/motion/{name}.py" for name in ("cycles", "masses", "dynamic_relaxation", "following", "motion")),
    *(f"solve/limit/{name}.py" for name in ("measure", "proof", "strength_factor")),
    *(
        f"solve/algebra/{name}.py"
        for name in ("constraints", "linear_solvers", "mixed_precision", "pardiso", "superlu")
    ),
    *(f"results/{name}.py" for name in ("movement", "spread")),
]
OF_THE_PLANE = {f"solve/continuation/{name}.py" for name in ("plane", "evidence", "wang", "shaken")}
OF_BOLTS = {"bolt_sums"}  # functions: bolts are the plane's
NUMBERS = (2, 3, 6)  # dimensions, and numbers that say how a block moved
NAMES = {"hypot", "arctan2", "area", "polar", "outlines", "edge_vectors", "atan2"}
COORDINATES = {"x", "y", "z", "u", "v", "w", "theta"}
MAKERS = {"zeros", "ones", "empty", "full", "reshape", "eye", "tile"}


def dimensions_in(source: str) -> list[str]:
    """Return the places of a source text that name a dimension, a line each."""
    tree = ast.parse(source)
    skipped = {id(node) for f in ast.walk(tree) if getattr(f, "name", "") in OF_BOLTS for node in ast.walk(f)}
    nodes = [node for node in ast.walk(tree) if id(node) not in skipped]
    return [f"{node.lineno}: {ast.unparse(node)[:70]}" for node in nodes if _names_dimension(node)]


def _names_dimension(node: ast.AST) -> bool:
    if isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Tuple):
        return any(_is_number(part) for index in node.slice.elts[1:] for part in ast.walk(index))
    if isinstance(node, ast.Call):
        name = getattr(node.func, "attr", getattr(node.func, "id", ""))
        numbers = [part for given in node.args for part in (given, *getattr(given, "elts", ()))]
        return name in MAKERS and any(_is_number(part) for part in numbers)
    if isinstance(node, ast.Tuple) and isinstance(node.ctx, ast.Store):
        return len(COORDINATES & {getattr(part, "id", "") for part in node.elts}) > 1
    return isinstance(node, ast.Attribute) and node.attr in NAMES


def _is_number(node: ast.AST) -> bool:
    return isinstance(node, ast.Constant) and type(node.value) is int and node.value in NUMBERS


def test_shared_rooms_name_no_dimension():
    places = [PACKAGE / name for name in SHARED]
    files = [file for place in places for file in (sorted(place.rglob("*.py")) if place.is_dir() else [place])]
    found = {
        name: lines
        for file in files
        if (name := str(file.relative_to(PACKAGE))) not in OF_THE_PLANE
        and (lines := dimensions_in(file.read_text(encoding="utf-8")))
    }
    assert found == {}


@pytest.mark.parametrize(
    ("text", "wrong"),
    [
        ("np.hypot(*moved[:, :2].T)", True),
        ("position[:, 2]", True),
        ("force[..., :3]", True),
        ("points.reshape(-1, 3)", True),
        ("np.zeros((n, 3))", True),
        ("np.eye(3)", True),
        ("x, y = point", True),
        ("for u, v, theta in movement:\n    pass", True),
        ("blocks.moments.area", True),
        ("np.zeros((n, axes))", False),
        ("distances(moved)", False),
        ("norms[-3]", False),
        ("tried[:2]", False),
        ("blocks.moments.bulk", False),
    ],
)
def test_the_search_finds_dimensions(text, wrong):
    assert bool(dimensions_in(text)) == wrong

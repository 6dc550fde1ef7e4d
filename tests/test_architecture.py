"""Arrows between folders, and between the rooms of `bsm_mesh.solve`, point one way; `import bsm_mesh` stays light."""

import ast
import subprocess
import sys
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PARTS = {"bsm_mesh": "bsm_mesh", "geometries": "bsm_mesh.geometries", "converters": "bsm_mesh.converters"}  # by folder
FOR_CONVERTERS = (
    "bsm_mesh.model",
    "bsm_mesh.results",
    "bsm_mesh.errors",
    "bsm_mesh.arrays",
    "bsm_mesh.merged_points",
    "bsm_mesh.files",
    "bsm_mesh.reading",
    "bsm_mesh.section_plane",
    "bsm_mesh.table_rows",
    "bsm_mesh.named_units",
    "bsm_mesh.processes",
    "bsm_mesh.signals",
    "bsm_mesh.three_d.blocks",
    "bsm_mesh.three_d.key_blocks",
    "bsm_mesh.three_d.joint_polygons",
    "bsm_mesh.movements",
    "bsm_mesh.lazy",
    "bsm_mesh.solve.zones",
    "bsm_mesh.geometries.physical_groups",
)
FOR_GEOMETRIES = (
    "bsm_mesh.merged_points",
    "bsm_mesh.lazy",
    "bsm_mesh.files",
    "bsm_mesh.errors",
    "bsm_mesh.reading",
    "bsm_mesh.section_plane",
    "bsm_mesh.table_rows",
    "bsm_mesh.named_units",
)
HEAVY = (
    "pint",
    "pydantic",
    "gmsh",
    "vtk",
    "vtkmodules",
    "meshio",
    "skfem",
    "pyvista",
    "matplotlib",
    "pyarrow",
    "distributed",
    "bokeh",
    "numba",
    "scipy.sparse",
)


ROOMS = {  # a folder or a file of bsm_mesh/solve, and the others that it may import; docs/architecture.md
    "algebra": set(),
    "bolts": {"algebra"},
    "stages": set(),
    "step": {"algebra", "bolts"},
    "linear": {"algebra", "bolts", "stages"},
    "limit": {"algebra", "bolts", "stages"},
    "motion": {"algebra", "bolts", "step"},
    "methods": {"algebra", "step"},
    "continuation": {"algebra", "bolts", "methods", "motion", "stages", "step"},
    "zones": {"algebra", "bolts", "motion", "stages"},
}
APPLICATION = {  # folders of bsm_mesh from the ground, and which of them each may import
    "text": set(),
    "modelfile": {"text"},
    "certificate": set(),
    "folder": {"certificate", "modelfile", "text"},
    "pictures": {"folder", "text"},
    "pages": {"folder", "modelfile", "pictures", "text"},
    "commands": {"folder", "modelfile", "pages", "pictures", "text"},
}
DOORS = {"cluster", "limit_analysis", "options"}  # hand names on to scripts, define nothing
ROOMS_3D = {  # of bsm_mesh/three_d: the others that each may import
    "blocks": set(),
    "stress_field": set(),
    "model": {"blocks", "stress_field"},
    "contacts": {"blocks"},
    "loads": {"blocks", "contacts"},
    "step": {"contacts", "loads"},
    "bolts": set(),
    "motion": {"bolts", "contacts"},
    "point_forces": set(),
    "evidence": {"contacts", "step"},
    "record": {"contacts", "evidence", "loads", "point_forces", "step"},
    "joint_polygons": {"point_forces"},
    "proof": {"blocks", "limit", "step"},
    "check": {"overlap"},
    "readiness": {"model", "overlap"},
    "overlap": {"blocks", "contacts"},
    "in_situ": {"contacts", "loads", "step", "stress_field"},
    "mechanics": {"contacts", "in_situ", "motion", "record", "step"},
    "limit": {"blocks", "bolts", "contacts", "model", "step"},
    "key_blocks": {"blocks", "loads", "model"},
}


def module_name(path: Path, root: Path) -> str:
    folder, *parts = path.relative_to(root).with_suffix("").parts
    name = ".".join([PARTS[folder], *parts])
    return name.removesuffix(".__init__")


def imports(source: str, module: str, is_package: bool, types: bool = True) -> list[tuple[str, bool, int]]:
    """Return (imported module, whether it is done when the module is loaded, line) of every import of a source text.

    `types` says whether what is imported for types only counts.
    """
    found = all_imports(source, module, is_package)
    return [(name, at_load, line) for name, at_load, line, for_types in found if types or not for_types]


@cache
def all_imports(source: str, module: str, is_package: bool) -> list[tuple[str, bool, int, bool]]:
    """Return the imports as `imports` does, each with whether it is for types only."""
    found = []

    def is_for_types_only(node: ast.AST) -> bool:
        return isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test)

    def visit(node: ast.AST, at_load: bool, for_types: bool) -> None:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.expr):  # imports are statements
                continue
            if isinstance(child, ast.Import):
                found.extend((alias.name, at_load, child.lineno, for_types) for alias in child.names)
            elif isinstance(child, ast.ImportFrom):
                base = child.module or ""
                if child.level:
                    package = module.split(".") if is_package else module.split(".")[:-1]
                    package = package[: len(package) - child.level + 1]
                    base = ".".join([*package, base] if base else package)
                found.extend((f"{base}.{alias.name}", at_load, child.lineno, for_types) for alias in child.names)
            only_types = is_for_types_only(child)
            later = isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef) or only_types
            visit(child, at_load and not later, for_types or only_types)

    visit(ast.parse(source), True, False)
    return found


def below(name: str, package: str) -> bool:
    return name == package or name.startswith(package + ".")


def part_of(name: str) -> str | None:
    """Return the folder a module belongs to; by the folder's own name it belongs to none."""
    return next((part for part, package in reversed(PARTS.items()) if below(name, package)), None)


def is_allowed(module: str, name: str, at_load: bool) -> bool:
    """Return whether a module may import `name`, which belongs to another folder."""
    part = part_of(module)
    if name == "bsm_mesh.checkout.hand_over":
        return module == PARTS.get(part or "") and part != "bsm_mesh"
    if part == "geometries":
        return any(below(name, target) for target in FOR_GEOMETRIES)
    if part == "converters":
        return any(below(name, target) for target in FOR_CONVERTERS)
    return part == "bsm_mesh" and any(below(module, f"bsm_mesh.{room}") for room in APPLICATION) and not at_load


def wrong_arrows(root: Path) -> list[str]:
    """Return one sentence for every import against the design."""
    wrong = []
    for folder in PARTS:
        for path in sorted((root / folder).rglob("*.py")):
            if "starters" in path.parts[:-2]:  # a user's script, copied and never imported
                continue
            module = module_name(path, root)
            for name, at_load, line in imports(path.read_text(encoding="utf-8"), module, path.stem == "__init__"):
                by_own_name = name.partition(".")[0] in ("geometries", "converters")  # not there in the wheel
                leaves = part_of(name) not in (None, folder)
                if by_own_name or (leaves and not is_allowed(module, name, at_load)):
                    wrong.append(f"{path.relative_to(root)}:{line} imports {name}")
    return wrong


def test_no_wrong_arrow():
    assert wrong_arrows(ROOT) == []


def arrows_between_rooms(root: Path, package: str = "bsm_mesh.solve") -> dict[str, set[str]]:
    """Return which other rooms each room of a package imports, when loaded or later."""
    folder, arrows = root.joinpath(*package.split(".")), {}
    for path in sorted(folder.rglob("*.py")):
        if path.parent == folder and path.stem in DOORS | {"__init__"}:
            continue
        module = module_name(path, root)
        room = module.removeprefix(f"{package}.").split(".")[0]
        known = arrows.setdefault(room, set())
        for name, _, _ in imports(path.read_text(encoding="utf-8"), module, path.stem == "__init__"):
            if below(name, package) and name != package:
                known.add(name.removeprefix(f"{package}.").split(".")[0])
        known.discard(room)
    return arrows


def floors(arrows: dict[str, set[str]]) -> dict[str, int]:
    """Return the floor of every room, 1 where it imports none; raise `RecursionError` on a circle."""

    def floor(room: str) -> int:
        return 1 + max((floor(other) for other in arrows[room]), default=0)

    return {room: floor(room) for room in arrows}


def test_rooms_of_the_solver():
    arrows = arrows_between_rooms(ROOT)
    assert set(arrows) == set(ROOMS)
    assert {room: others - ROOMS[room] for room, others in arrows.items() if others - ROOMS[room]} == {}
    assert len(arrows) <= 10
    assert sum(map(len, arrows.values())) <= 28
    assert max(floors(arrows).values()) <= 5


def test_rooms_of_three_dimensions():
    """They know the plane's materials and words; what is shared comes to them by few doors, by the kind of blocks."""
    arrows = arrows_between_rooms(ROOT, "bsm_mesh.three_d")
    assert set(arrows) == set(ROOMS_3D)
    assert {room: others - ROOMS_3D[room] for room, others in arrows.items() if others - ROOMS_3D[room]} == {}
    assert max(floors(arrows).values()) <= 7
    doors = {
        "bsm_mesh/__init__.py",
        "bsm_mesh/space.py",
        "bsm_mesh/model/kinds.py",
    }  # names for scripts; by kind; its type
    users = {
        str(path.relative_to(ROOT))
        for path in sorted((ROOT / "bsm_mesh").rglob("*.py"))
        for name, _, _ in imports(path.read_text(encoding="utf-8"), module_name(path, ROOT), path.stem == "__init__")
        if below(name, "bsm_mesh.three_d") and not below(module_name(path, ROOT), "bsm_mesh.three_d")
    }
    assert users - doors == {user for user in users if user.split("/")[1] in APPLICATION}


def test_rooms_of_the_application():
    arrows = arrows_between_rooms(ROOT, "bsm_mesh")
    found = {room: arrows[room] & set(APPLICATION) for room in APPLICATION}
    assert found == APPLICATION
    assert max(floors(found).values()) <= 6


def arrows_between_modules(root: Path) -> dict[str, set[str]]:
    """Return which modules of the project each imports, when loaded or later, but not for types only."""
    files = [p for folder in PARTS for p in (root / folder).rglob("*.py") if "starters" not in p.parts[:-2]]
    modules = {module_name(path, root): path for path in files}

    def known(name: str) -> str:
        return name if name in modules else name.rpartition(".")[0]

    return {
        module: {
            known(name)
            for name, _, _ in imports(path.read_text(encoding="utf-8"), module, path.stem == "__init__", types=False)
            if known(name) in modules and known(name) != module
        }
        for module, path in modules.items()
    }


def test_no_circle_of_modules():
    """Imports inside functions count: what hangs together so cannot be read, tested or taken away alone.

    The one way up is `bsm_mesh.doors`, by names: what `Model` and `Results` hand themselves to.
    """
    TopologicalSorter(arrows_between_modules(ROOT)).prepare()


def test_the_walk_finds_a_circle_of_modules(tmp_path):
    (tmp_path / "bsm_mesh").mkdir()
    (tmp_path / "bsm_mesh/one.py").write_text("from bsm_mesh.two import f", encoding="utf-8")
    (tmp_path / "bsm_mesh/two.py").write_text("def f():\n    from bsm_mesh import one", encoding="utf-8")
    with pytest.raises(CycleError):
        TopologicalSorter(arrows_between_modules(tmp_path)).prepare()


FOR_STUDIES = ("model", "arrays", "errors", "files", "studies", "version", "worker_pool")


def test_studies_know_neither_solver_nor_command_line():
    """What is done in a run comes to them as `Work`."""
    wrong = [
        f"{path.name}:{line} imports {name}"
        for path in sorted((ROOT / "bsm_mesh" / "studies").glob("*.py"))
        for name, _, line in imports(path.read_text(encoding="utf-8"), module_name(path, ROOT), False)
        if below(name, "bsm_mesh") and name.split(".")[1] not in FOR_STUDIES
    ]
    assert wrong == []


def test_doors_define_nothing():
    for door in DOORS:
        tree = ast.parse((ROOT / "bsm_mesh" / "solve" / f"{door}.py").read_text(encoding="utf-8"))
        assert not [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.ClassDef)]


def test_the_walk_finds_a_circle_of_rooms(tmp_path):
    folder = tmp_path / "bsm_mesh" / "solve"
    for room, other in (("one", "two"), ("two", "one")):
        (folder / room).mkdir(parents=True)
        (folder / room / "a.py").write_text(f"def f():\n    from bsm_mesh.solve.{other}.a import f", encoding="utf-8")
    arrows = arrows_between_rooms(tmp_path)
    assert arrows == {"one": {"two"}, "two": {"one"}}
    with pytest.raises(RecursionError):
        floors(arrows)


def test_geometries_need_no_gmsh_to_be_imported():
    for name in ("__init__.py", "physical_groups.py"):
        found = imports((ROOT / "geometries" / name).read_text(encoding="utf-8"), PARTS["geometries"], True)
        assert not [i for i in found if below(i[0], "gmsh")]


@pytest.mark.parametrize(
    ("path", "text", "wrong"),
    [
        ("geometries/case.py", "from bsm_mesh import converters", True),
        ("geometries/case.py", "from bsm_mesh.files import whole_file", False),
        ("geometries/case.py", "import bsm_mesh.converters", True),
        ("geometries/case.py", "def build():\n    from bsm_mesh.model import Blocks", True),
        ("geometries/case.py", "from bsm_mesh.geometries.session import gmsh_session\nimport gmsh", False),
        ("geometries/case.py", "from geometries.session import gmsh_session", True),
        ("geometries/__init__.py", "from bsm_mesh.checkout import hand_over", False),
        ("geometries/case.py", "from bsm_mesh.checkout import hand_over", True),
        ("converters/meshes.py", "from bsm_mesh.model import Blocks\nfrom bsm_mesh.errors import ModelError", False),
        ("converters/meshes.py", "from bsm_mesh.geometries.physical_groups import parse_group_name", False),
        ("converters/meshes.py", "from bsm_mesh.geometries import tunnel", True),
        ("converters/meshes.py", "import converters", True),
        ("converters/meshes.py", "from bsm_mesh.solve.linear import solve_linear", True),
        ("converters/meshes.py", "import bsm_mesh.run", True),
        ("bsm_mesh/run.py", "from bsm_mesh import converters", True),
        ("bsm_mesh/run.py", "def run():\n    from bsm_mesh import converters", True),
        ("bsm_mesh/commands/cli.py", "def run():\n    from bsm_mesh import converters", False),
        ("bsm_mesh/commands/cli.py", "def run():\n    import converters", True),
        ("bsm_mesh/commands/cli.py", "if True:\n    from bsm_mesh import converters", True),
        ("bsm_mesh/commands/cli.py", "class A:\n    from bsm_mesh.geometries import tunnel", True),
        (
            "bsm_mesh/commands/cli.py",
            "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    import bsm_mesh.converters",
            False,
        ),
        ("converters/inner.py", "from . import meshes\nfrom .meshes import a", False),
    ],
)
def test_the_walk_finds_wrong_arrows(tmp_path, path, text, wrong):
    file = tmp_path / path
    file.parent.mkdir(parents=True)
    file.write_text(text, encoding="utf-8")
    assert bool(wrong_arrows(tmp_path)) == wrong


def loaded_by(statement: str) -> set[str]:
    code = f"import sys; {statement}; print('\\n'.join(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    return set(done.stdout.split())


HELP = "from bsm_mesh.commands.cli import cli; cli.main(['run', '--help'], standalone_mode=False)"


@pytest.mark.parametrize("statement", ["import bsm_mesh", "import bsm_mesh.model, bsm_mesh.results", HELP])
def test_importing_the_package_stays_light(statement):
    modules = loaded_by(statement)
    assert "bsm_mesh" in modules
    assert sorted(m for m in modules for heavy in HEAVY if below(m, heavy)) == []
    assert sorted(m for m in modules if part_of(m) in ("geometries", "converters")) == []


def test_importing_geometries_adds_no_library():
    added = loaded_by("import bsm_mesh.geometries.physical_groups") - loaded_by("import bsm_mesh")
    assert sorted(m for m in added for library in ("numpy", *HEAVY) if below(m, library)) == []
    assert {part_of(m) for m in added if below(m, "bsm_mesh")} <= {"geometries", "bsm_mesh"}


@pytest.mark.parametrize("name", ["files", "signals"])
def test_what_all_packages_use_needs_nothing_of_the_project(name):
    source = (ROOT / f"bsm_mesh/{name}.py").read_text(encoding="utf-8")
    assert not [i for i in imports(source, f"bsm_mesh.{name}", False) if "bsm" in i[0]]

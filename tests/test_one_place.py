"""Functions fit on a screen, files are short; writers and starters of processes stand once; no benchmark in tests."""

import ast
from pathlib import Path

import pytest

from tests.test_architecture import PARTS, below, imports

ROOT = Path(__file__).parent.parent


MOST_LINES = 400  # of a file
SCREEN = 60  # lines of a function of the solver, signature and docstring with it: whoever checks it sees all of it


def long_functions(source: str, most: int = SCREEN) -> dict[str, int]:
    """Return name and lines of every function that is longer than a screen."""
    kinds = ast.FunctionDef | ast.AsyncFunctionDef
    functions = [node for node in ast.walk(ast.parse(source)) if isinstance(node, kinds)]
    lines = {node.name: (node.end_lineno or 0) - node.lineno + 1 for node in functions}
    return {name: count for name, count in lines.items() if count > most}


@pytest.mark.heavy
def test_functions_of_the_solver_fit_on_a_screen():
    files = [
        path for house in ("contact", "solve", "three_d") for path in sorted((ROOT / "bsm_mesh" / house).rglob("*.py"))
    ]
    found = {str(path.relative_to(ROOT)): long_functions(path.read_text(encoding="utf-8")) for path in files}
    assert {path: functions for path, functions in found.items() if functions} == {}


def test_files_fit_in_a_head():
    folders = ("bsm_mesh", "converters", "geometries", "tests", "benchmarks", "tools", "verification")
    files = [path for folder in folders for path in (ROOT / folder).rglob("*.py")]
    lines = {str(path.relative_to(ROOT)): len(path.read_text(encoding="utf-8").splitlines()) for path in files}
    assert {path: count for path, count in lines.items() if count > MOST_LINES} == {}


def test_the_walk_finds_long_functions():
    assert long_functions("class A:\n    def f(a,\n          b):\n        a\n        b\n", 3) == {"f": 4}
    assert long_functions("def f():\n    pass\n", 3) == {}


CHANGING = {  # what makes, moves or removes files
    "os": {"open", "rename", "renames", "replace", "remove", "unlink", "mkdir", "makedirs", "rmdir", "link", "symlink"},
    "shutil": {"rmtree", "copy", "copy2", "copyfile", "copytree", "move"},
    "tempfile": {"TemporaryDirectory", "NamedTemporaryFile", "mkdtemp", "mkstemp"},
}
PATH_METHODS = {"mkdir", "rmdir", "unlink", "rename", "touch", "symlink_to", "hardlink_to", "chmod", "truncate"}
WRITERS = {ROOT / "bsm_mesh/files.py", ROOT / "bsm_mesh/locks.py"}  # a lock's file holds no data
WRITING = {  # to a file by name
    *("write_text", "write_bytes", "savefig", "imsave", "print_png", "Write", "save", "SetFileName"),
    *("tofile", "savez", "savez_compressed", "savetxt", "to_csv"),
}
CALLED = {"open", "replace", "screenshot", "write"}.union(
    *CHANGING.values(), PATH_METHODS, WRITING
)  # names of all these
DRAFTS = ("draft", "self.draft", "str(draft)", "str(self.draft)")


def writers(source: str) -> list[str]:
    """Return a call for every place that changes files without `bsm_mesh.files`, or writes other than to a draft."""
    found: list[str] = []
    if not any(f"{name}(" in source for name in CALLED):
        return found

    def visit(node: ast.AST, drafted: bool) -> None:
        if isinstance(node, ast.With) and any("whole_file(" in ast.unparse(item) for item in node.items):
            drafted = True
        if isinstance(node, ast.Call) and _changes(node, drafted):
            found.append(f"{node.lineno}: {ast.unparse(node)[:60]}")
        for child in ast.iter_child_nodes(node):
            visit(child, drafted)

    visit(ast.parse(source), False)
    return found


def called(call: ast.Call) -> str:
    """Return the last name of what is called."""
    return getattr(call.func, "attr", getattr(call.func, "id", ""))


def _changes(call: ast.Call, drafted: bool) -> bool:
    if called(call) not in CALLED:
        return False
    name = ast.unparse(call.func)
    if isinstance(call.func, ast.Name):
        return name == "open" and _for_writing(call) and not drafted
    if not isinstance(call.func, ast.Attribute):
        return False
    module, _, attribute = name.rpartition(".")
    if attribute in CHANGING.get(module, ()):
        return "os.devnull" not in ast.unparse(call)
    if attribute in PATH_METHODS or (attribute == "replace" and len(call.args) == 1 and not call.keywords):
        return True
    if attribute in WRITING or (attribute == "screenshot" and call.args) or name == "gmsh.write":
        on_a_draft = drafted or module == "self.draft" or any(ast.unparse(word) in DRAFTS for word in call.args)
        return not on_a_draft and not (attribute == "SetFileName" and module == "reader")
    return attribute == "open" and _for_writing(call) and not drafted


def _for_writing(call: ast.Call) -> bool:
    modes = [arg.value for arg in (*call.args, *(k.value for k in call.keywords)) if isinstance(arg, ast.Constant)]
    return any(isinstance(mode, str) and set(mode) & set("wax+") and set(mode) <= set("wabtrx+") for mode in modes)


@pytest.mark.heavy
def test_files_are_written_by_the_one_writer():
    """Whole or not at all: nothing else makes, moves, removes or writes a file; a user's script may."""
    wrong = [
        f"{path.relative_to(ROOT)}:{text}"
        for package in PARTS
        for path in sorted((ROOT / package).rglob("*.py"))
        if path not in WRITERS and "starters" not in path.parts[:-2]
        for text in writers(path.read_text(encoding="utf-8"))
    ]
    assert wrong == []


@pytest.mark.parametrize(
    ("text", "wrong"),
    [
        ("path.write_text('a')", True),
        ("with whole_file(path) as draft:\n    draft.write_text('a')", False),
        ("open(path, 'w')", True),
        ("path.open('wb')", True),
        ("path.open('rb')", False),
        ("with whole_file(path) as draft, draft.open('w', newline='') as file:\n    file.write('a')", False),
        ("with whole_file(path) as draft:\n    other.unlink()", True),
        ("draft.replace(path)", True),
        ("text.replace('a', 'b')", False),
        ("os.replace(a, b)", True),
        ("shutil.rmtree(folder)", True),
        ("figure.savefig(path)", True),
        ("writer.SetFileName(str(path))", True),
        ("writer.SetFileName(str(draft))", False),
        ("np.savez(path, a=a)", True),
        ("plotter.screenshot(return_img=True)", False),
        ("gmsh.write(str(path))", True),
    ],
)
def test_the_search_finds_other_writers(text, wrong):
    assert bool(writers(text)) == wrong


ONLY_THERE = {  # what is done in one module only, so that its care is taken everywhere
    "print": {
        "bsm_mesh/text/terminal.py",
        "bsm_mesh/pictures/compare_pictures.py",
        "bsm_mesh/pictures/pictures.py",
        "bsm_mesh/pictures/animation.py",
        "bsm_mesh/certificate/verify_certificate/folder.py",
    },  # the three that draw: a pipe; the last imports nothing of the package
    "click.echo": set(),
    "sys.stderr.write": set(),
    "sys.stdout.write": set(),
    "numba.njit": {"bsm_mesh/compiled.py"},
    "nb.njit": set(),
    "csv.writer": {"bsm_mesh/text/csv_tables.py"},
    "csv.DictWriter": set(),
    "csv.reader": {"bsm_mesh/table_rows.py"},
    "csv.DictReader": {"bsm_mesh/text/csv_tables.py"},
}


def calls(source: str) -> list[str]:
    """Return the calls of functions that are called in one module only."""
    names = {name.rpartition(".")[2] for name in ONLY_THERE}
    if not any(name in source for name in names):
        return []
    nodes = [node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Call) and called(node) in names]
    return [ast.unparse(node.func) for node in nodes]


@pytest.mark.heavy
def test_what_is_done_in_one_module_only():
    found = {
        (name, str(path.relative_to(ROOT)))
        for folder in PARTS
        for path in sorted((ROOT / folder).rglob("*.py"))
        if "starters" not in path.parts[:-2]
        for name in calls(path.read_text(encoding="utf-8"))
        if name in ONLY_THERE and str(path.relative_to(ROOT)) not in ONLY_THERE[name]
    }
    assert found == set()


def test_a_python_of_our_own_is_started_by_processes_only():
    text = {path: path.read_text(encoding="utf-8") for folder in PARTS for path in (ROOT / folder).rglob("*.py")}
    assert [path.name for path, source in text.items() if "sys.executable" in source] == ["processes.py"]


def importers_of(packages: tuple[str, ...], folder: Path, root: Path) -> list[str]:
    """Return the files below a folder that import one of some packages, or name it to one that imports by name."""
    by_name = {"importlib.import_module", "import_module", "pytest.importorskip", "__import__"}

    def names(path: Path) -> list[str]:
        source = path.read_text(encoding="utf-8")
        if not any(package in source for package in packages):
            return []
        asked = [
            arg.value
            for node in ast.walk(ast.parse(source))
            if isinstance(node, ast.Call) and ast.unparse(node.func) in by_name
            for arg in node.args
            if isinstance(arg, ast.Constant) and isinstance(arg.value, str)
        ]
        return [name for name, _, _ in imports(source, path.stem, False)] + asked

    found = sorted(folder.rglob("*.py"))
    return [
        str(path.relative_to(root))
        for path in found
        if any(below(name, package) for name in names(path) for package in packages)
    ]


@pytest.mark.heavy
def test_no_test_of_the_program_imports_commands_of_the_checkout():
    """Scenes of both are in ``tests/scenes``; tests of the commands lie beside these."""
    assert importers_of(("benchmarks", "tools"), ROOT / "tests", ROOT) == []


@pytest.mark.parametrize(
    ("text", "wrong"),
    [
        ("from benchmarks.campaign import sizes", True),
        ("def f():\n    import benchmarks", True),
        ("scenes = pytest.importorskip('benchmarks.scenes')", True),
        ("from tests.scenes import large", False),
    ],
)
def test_the_walk_finds_importers_of_benchmarks(tmp_path, text, wrong):
    (tmp_path / "test_a.py").write_text(text, encoding="utf-8")
    assert bool(importers_of(("benchmarks",), tmp_path, tmp_path)) == wrong

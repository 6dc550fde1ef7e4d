"""Mutants of a source file: one operator, comparison or number of it changed, by the operators of Cosmic Ray."""

from __future__ import annotations

import ast
import difflib
import hashlib
import json
import random
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
FOLDERS = ("bsm_mesh/contact", "bsm_mesh/solve")
# An error of type follows from the others at once (a shift of a float), which kills for nothing.
PLAUSIBLE = re.compile(
    r"core/(ReplaceBinaryOperator_(Add|Sub|Mul|Div)_(Add|Sub|Mul|Div)$|ReplaceBinaryOperator_Bit(Or|And)_Bit(Or|And)$"
    r"|ReplaceComparisonOperator_(Eq|NotEq|Lt|LtE|Gt|GtE)_(Eq|NotEq|Lt|LtE|Gt|GtE)$|ReplaceComparisonOperator_Is"
    r"|ReplaceUnaryOperator_Delete_|AddNot|ReplaceTrue|ReplaceFalse|ReplaceAnd|ReplaceOr|ReplaceBreak|ReplaceContinue"
    r"|NumberReplacer|ZeroIterationForLoop)"
)
UNCHANGED = {"name", "newline", "string", "endmarker", "indent", "dedent", "param", "trailer", "arglist", "argument"}


@dataclass(frozen=True)
class Mutant:
    """A change of a file: the n-th one that an operator makes."""

    file: str
    operator: str
    occurrence: int
    line: int
    column: int

    @property
    def room(self) -> str:
        """The folder of the file below ``bsm_mesh``."""
        return str(Path(self.file).parent.relative_to("bsm_mesh"))

    def key(self, source: str) -> str:
        """Return a name that changes with the file."""
        return f"{self.file}:{self.operator}:{self.occurrence}:{hashlib.sha256(source.encode()).hexdigest()[:12]}"


def files() -> list[str]:
    """Return what is mutated, relative to the root."""
    found = [path for folder in FOLDERS for path in (ROOT / folder).rglob("*.py") if path.name != "__init__.py"]
    return sorted(str(path.relative_to(ROOT)) for path in found)


def read(file: str) -> str:
    return (ROOT / file).read_text(encoding="utf-8")


def sample(seed: int, chosen: list[str], store: Path) -> Iterator[Mutant]:
    """Return one mutant of every place in files, in random order: a larger sample begins with a smaller one.

    All mutants are found once (minutes), and read from `store` where the sources are the same.
    """
    rng = random.Random(seed)
    places: dict[tuple[str, int, int], list[Mutant]] = {}
    for mutant in all_mutants(store):
        if mutant.file in chosen:
            places.setdefault((mutant.file, mutant.line, mutant.column), []).append(mutant)
    order = sorted(places)
    rng.shuffle(order)
    for place in order:
        mutant = rng.choice(places[place])
        if matters(read(mutant.file), mutated(read(mutant.file), mutant)):
            yield mutant


def all_mutants(store: Path) -> list[Mutant]:
    """Return the mutants of all files."""
    sources = {file: hashlib.sha256(read(file).encode()).hexdigest() for file in files()}
    kept = json.loads(store.read_text(encoding="utf-8")) if store.exists() else {}
    for file, digest in sources.items():
        if kept.get(file, {}).get("source") != digest:
            found = [[m.operator, m.occurrence, m.line, m.column] for m in mutants_of(file, read(file))]
            kept[file] = {"source": digest, "mutants": found}
    store.write_text(json.dumps(kept), encoding="utf-8")
    return [Mutant(file, *row) for file in sources for row in kept[file]["mutants"]]


def mutants_of(file: str, source: str) -> Iterator[Mutant]:
    """Return all mutants of a source text that operators we take make."""
    import cosmic_ray.plugins
    from cosmic_ray.ast import ast_nodes, get_ast

    nodes = [node for node in ast_nodes(get_ast(source)) if node.type not in UNCHANGED]
    for name in filter(PLAUSIBLE.match, cosmic_ray.plugins.operator_names()):
        operator = cosmic_ray.plugins.get_operator(name)()
        places = [begin for node in nodes for begin, _ in operator.mutation_positions(node)]
        for occurrence, (line, column) in enumerate(places):
            yield Mutant(file, name, occurrence, line, column)


def mutated(source: str, mutant: Mutant) -> str:
    """Return the changed text."""
    import cosmic_ray.plugins
    from cosmic_ray.mutating import mutate_code

    changed = mutate_code(source, cosmic_ray.plugins.get_operator(mutant.operator)(), mutant.occurrence)
    assert changed is not None
    return str(changed)


def matters(source: str, changed: str) -> bool:
    """Return whether a change is of what is computed: no annotation, decorator, or value of a setting.

    What a setting's value is worth the campaign measures (``python -m benchmarks.campaign --set``).
    """
    try:
        return _computed(source) != _computed(changed)
    except SyntaxError:
        return False


class _Computed(ast.NodeTransformer):
    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        node.returns, node.decorator_list = None, []
        for arg in (*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs):
            arg.annotation = None
        return self.generic_visit(node)

    def visit_ClassDef(self, node: ast.ClassDef) -> ast.AST:
        node.decorator_list = []
        if node.name.endswith(("Settings", "Rules")):
            node.body = [part for part in node.body if not isinstance(part, ast.AnnAssign)] or [ast.Pass()]
        return self.generic_visit(node)

    def visit_AnnAssign(self, node: ast.AnnAssign) -> ast.AST:
        node.annotation = ast.Constant(None)
        return self.generic_visit(node)


def _computed(source: str) -> str:
    tree = ast.parse(source)
    tree.body = [node for node in tree.body if not _is_setting(node)]
    return ast.dump(_Computed().visit(tree))


def _is_setting(node: ast.stmt) -> bool:
    """Return whether a statement of a module gives constants their values (``AT_ONCE = 4096``)."""
    targets = node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
    names = [name.id for target in targets for name in ast.walk(target) if isinstance(name, ast.Name)]
    return bool(names) and all(name.isupper() for name in names)


def diff(source: str, changed: str) -> list[str]:
    """Return the lines that differ, with - and +."""
    lines = difflib.unified_diff(source.splitlines(), changed.splitlines(), n=0, lineterm="")
    return [line[0] + " " + line[1:].strip() for line in lines if line[:2] not in ("--", "++", "@@")]

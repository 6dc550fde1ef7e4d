"""Cases by name or by a user's own script: anything with ``build(path, **parameters)``.

``find_case("circular_tunnel")`` is a module of this package; ``find_case("slopes/north.py")`` is a
script.
"""

from __future__ import annotations

import contextlib
import importlib
import importlib.util
import inspect
import os
import pkgutil
import sys
import traceback
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

from bsm_mesh.errors import nearest
from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.reading import refuse_special
from bsm_mesh.geometries.settings import Parameter, accepts_any, parse_literal, read_parameters


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """A geometry that can be built.

    Attributes
    ----------
    name : str
        Name of the module, or of the script without its ending.
    function : callable
        ``build(path, **parameters)``.
    script : Path or None
        The user's script; None for a case of this package.
    """

    name: str
    function: Callable[..., object]
    script: Path | None = None

    @property
    def summary(self) -> str:
        """First line of the module's docstring, else of the function's."""
        document = inspect.getdoc(inspect.getmodule(self.function)) or inspect.getdoc(self.function) or ""
        return document.partition("\n")[0]

    def build(self, path: str | os.PathLike[str], **parameters: object) -> Path:
        """Write the mesh to `path` and return it.

        Raises
        ------
        GeometryError
            For bad parameters; where a user's script raises, with its file and line, and its
            exception as ``__cause__``.
        """
        target = Path(path)
        if self.script is None:
            self.function(target, **parameters)
            return target
        _raise_faults(_name_faults(self, parameters))
        before = _time_of_change(target)
        with _located_errors(self.script):
            self.function(target, **parameters)
        if _time_of_change(target) in (None, before):
            raise GeometryError(f"{self.script}: build wrote no file {target}; end it with gmsh.write(str(path))")
        return target


def case_names() -> tuple[str, ...]:
    """Return the names of the cases in this package, sorted.

    Examples
    --------
    >>> from bsm_mesh import geometries as g
    >>> "circular_tunnel" in g.case_names()
    True
    """
    return tuple(sorted(name for name in _module_names() if hasattr(_import_module(name), "build")))


def find_case(case: str | os.PathLike[str]) -> Case:
    """Return the case of this name, or the one in this script.

    Parameters
    ----------
    case : str or path-like
        For example ``circular_tunnel``, or the path of a file that ends in ``.py``.

    Raises
    ------
    GeometryError
        For an unknown name, with the nearest one; for a script that is not there, fails or has no
        ``build``.

    Examples
    --------
    >>> from bsm_mesh import geometries as g
    >>> g.find_case("circular_tunnel").name
    'circular_tunnel'
    """
    text = os.fspath(case)
    if isinstance(case, os.PathLike) or text.endswith(".py") or "/" in text or os.sep in text:
        return _load_script(Path(case))
    name = text.strip().replace("-", "_")
    known = case_names()
    if name not in known:
        raise GeometryError(
            f"there is no case '{text}'{nearest(name, known, most=len(known))}; give a known name, or the path of "
            "a .py file with build(path, **parameters)"
        )
    return Case(name=name, function=_import_module(name).build)


def case_parameters(case: Case) -> dict[str, Parameter]:
    """Return the parameters that the case takes, by name, in the order of its signature."""
    return read_parameters(case.function)


def parse_settings(case: Case, settings: Mapping[str, str]) -> dict[str, object]:
    """Return parameters for `Case.build` from texts, such as ``--set radius=2.5`` gives.

    Parameters
    ----------
    case : Case
        The case that they are for.
    settings : mapping of str to str
        Text by name of parameter; numbers are in SI units.

    Raises
    ------
    GeometryError
        For all unknown names and all texts that do not fit.
    """
    parameters = case_parameters(case)
    faults = _unknown_names(case, settings)
    values: dict[str, object] = {}
    for name, text in settings.items():
        try:
            values[name] = parameters[name].parse(text) if name in parameters else parse_literal(text)
        except GeometryError as fault:
            faults.extend(f"{case.name}: {sentence}" for sentence in fault.faults)
    _raise_faults(faults)
    return values


def _unknown_names(case: Case, given: Mapping[str, object]) -> list[str]:
    known = case_parameters(case)
    # A user's build(path, **parameters) takes any name; a case of this package refuses what it does not know.
    if case.script is not None and accepts_any(case.function):
        return []
    return [
        f"{case.name}: there is no parameter '{name}'{nearest(name, known, most=len(known))}"
        for name in given
        if name not in known
    ]


def _name_faults(case: Case, given: Mapping[str, object]) -> list[str]:
    required = [name for name, parameter in case_parameters(case).items() if parameter.required]
    missing = [name for name in required if name not in given]
    return _unknown_names(case, given) + [f"{case.name}: give the parameter '{name}'" for name in missing]


def _raise_faults(faults: list[str]) -> None:
    if faults:
        raise GeometryError(faults)


def _module_names() -> list[str]:
    package = importlib.import_module("bsm_mesh.geometries")
    names = (module.name for module in pkgutil.iter_modules(package.__path__))
    return [name for name in names if not name.startswith("_")]


def _import_module(name: str) -> Any:
    return importlib.import_module(f"bsm_mesh.geometries.{name}")


def _load_script(path: Path) -> Case:
    """Run a user's script and return its case; a script next to it can be imported."""
    refuse_special(path)
    if not os.path.isfile(path):
        known = [entry.name for entry in path.parent.glob("*.py")]
        hint = nearest(path.name, known) if known else ""
        raise GeometryError(f"there is no script {path}{hint}; give the path of a .py file with build(path)")
    if path.suffix != ".py":
        raise GeometryError(f"{path} is not a Python script; give a file that ends in .py")
    script = path.resolve()
    module = _run_script(script)
    function = getattr(module, "build", None)
    if not callable(function):
        raise GeometryError(f"{path} has no function build; define build(path, **parameters) in it")
    if not inspect.signature(function).parameters:
        raise GeometryError(f"{path}: build takes no path; define build(path, **parameters)")
    return Case(name=path.stem, function=function, script=script)


def _run_script(script: Path) -> ModuleType:
    name = f"geometries_script_{script.stem}_{abs(hash(str(script))):x}"
    spec = importlib.util.spec_from_file_location(name, script)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # a dataclass looks up its module there
    folder = str(script.parent)
    sys.path.append(folder)  # last: a random.py that lies there is not the one that libraries mean
    writes_bytecode = sys.dont_write_bytecode
    sys.dont_write_bytecode = True  # a user's folder gets no __pycache__ from us
    try:
        with _located_errors(script):
            spec.loader.exec_module(module)
    except GeometryError:
        del sys.modules[name]
        raise
    finally:
        sys.dont_write_bytecode = writes_bytecode
        if folder in sys.path:
            del sys.path[len(sys.path) - 1 - sys.path[::-1].index(folder)]
    return module


@contextlib.contextmanager
def _located_errors(script: Path) -> Iterator[None]:
    """Turn whatever a user's script raises into a `GeometryError` that names its file and line."""
    try:
        yield
    except (Exception, SystemExit) as fault:
        place = f"{script}, line {_line_in(script, fault) or '?'}"
        if isinstance(fault, GeometryError):
            sentences = fault.faults
        elif isinstance(fault, SyntaxError):
            sentences = (f"{type(fault).__name__}: {fault.msg}",)
        else:
            sentences = (f"{type(fault).__name__}: {fault}",)
        raise GeometryError([f"{place}: {sentence}" for sentence in sentences]) from fault


def _line_in(script: Path, fault: BaseException) -> int | None:
    """Return the line of the script nearest to the first cause of the fault."""
    if isinstance(fault, SyntaxError) and fault.filename == str(script):
        return fault.lineno
    # The session raises at the script's `with` line; what Gmsh raised within knows the line itself.
    if fault.__cause__ is not None and (line := _line_in(script, fault.__cause__)) is not None:
        return line
    frames = traceback.extract_tb(fault.__traceback__)
    lines = [frame.lineno for frame in frames if frame.filename == str(script)]
    return lines[-1] if lines else None


def _time_of_change(path: Path) -> tuple[int, int] | None:
    """Return what changes when a file is written, or None where it is not there."""
    try:
        status = path.stat()
    except OSError:
        return None
    return status.st_mtime_ns, status.st_ino

"""Kernels compiled by Numba, each kept in a file of its own: the first run on a machine waits for the compiler.

A file's name holds a digest of all that went into the kernel: its bytecode, that of all kernels that it calls, the
constants that they see, the types of its arguments, the level of the processor and the versions of the compiler. So a
kernel is compiled anew exactly where it has to be; files need no list of contents, which two processes could
write at once; and they can be copied to another machine. A file that is damaged or cannot be written stops no run.
"""

from __future__ import annotations

import contextlib
import hashlib
import pickle
import platform
import sys
from collections.abc import Callable, Iterator
from functools import cache
from types import CodeType, ModuleType
from typing import Any

import llvmlite
import llvmlite.binding
import numba
import numpy as np
from numba import types
from numba.core.caching import CompileResultCacheImpl
from numba.core.dispatcher import Dispatcher
from numba.core.runtime import rtsys
from numba.core.serialize import dumps
from numba.core.sigutils import normalize_signature

from bsm_mesh import kernel_files

PORTABLE = "x86-64-v3"  # the level of kernels that are made to be shared: AVX2 and FMA; x86 processors since 2013-2015
PORTABLE_FEATURES = ["avx", "avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe", "popcnt", "sse4.2"]
VERSIONS = f"{sys.implementation.cache_tag}-numba{numba.__version__}-llvmlite{llvmlite.__version__}"


def njit(*, allocates: bool = False, **options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Return Numba's decorator of this name, with files on disk.

    Parameters
    ----------
    allocates : bool
        Whether the kernel makes arrays, returns a slice, or calls a kernel that returns a new array. Such a kernel
        counts references to all arrays that it handles. Counts are atomic, and slow in a loop.
    **options
        As for ``numba.njit``, ``cache`` aside.
    """

    def compiled(function: Callable[..., Any]) -> Any:
        dispatcher = numba.njit(_nrt=allocates, **options)(function)
        dispatcher._cache = KernelCache(dispatcher)  # as its enable_caching() does with a FunctionCache
        return dispatcher

    return compiled


def compiled_into(kernel: Any) -> list[Any]:
    """Return a kernel, and the kernels that it calls, one through the other."""
    found = [kernel]
    for part in found:
        found += [new for new in called_by(part) if new not in found]
    return found


def called_by(kernel: Any) -> list[Any]:
    """Return the kernels that a kernel calls itself."""
    return [one for _, one in _seen(kernel.py_func) if isinstance(one, Dispatcher)]


class KernelCache:
    """What Numba asks for a kernel that is not in memory, and gives it when it is compiled."""

    cache_path = None  # part of Numba's statistics

    def __init__(self, kernel: Any) -> None:
        self._kernel = kernel
        self._form = _Form()

    def load_overload(self, signature: Any, target: Any) -> Any:
        """Return the kernel for a signature, or None, which has it compiled.

        Machine code needs Numba's run time alone; its compiler registers Python's functions when it is called.
        """
        rtsys.initialize(target)
        for level in levels():
            content = kernel_files.read(self.name(signature, level))
            if content is not None:
                with contextlib.suppress(Exception):  # unpickling something damaged raises anything
                    return self._form.rebuild(target, pickle.loads(content))
        kernel_files.compiling()
        return None

    def save_overload(self, signature: Any, compiled: Any) -> None:
        """Keep the compiled kernel of a signature."""
        kernel_files.write(self.name(signature, levels()[-1]), dumps(self._form.reduce(compiled)))

    def name(self, signature: Any, level: str) -> str:
        """Return the name of the kernel's file in the folder of kernels."""
        arguments, _ = normalize_signature(signature)
        told = (
            level,
            VERSIONS,
            np.__version__.partition(".")[0],
            _digest(self._kernel),
            arguments,
            *_fields(arguments),
        )
        digest = hashlib.sha256(repr(told).encode()).hexdigest()
        function = self._kernel.py_func
        plain = f"{function.__module__}.{function.__qualname__}".replace("<", "").replace(">", "")
        return f"{VERSIONS}/{plain.removeprefix('bsm_mesh.')}-{digest[:24]}.nbc"


class _Form(CompileResultCacheImpl):  # type: ignore[misc]
    """Numba's form of a compiled kernel on disk; files and their names are ours."""

    def __init__(self) -> None:
        pass

    def reduce(self, compiled: Any) -> tuple[Any, ...]:
        """Return it without environments that have no constants: they are never read, but import Numba's modules."""
        *parts, environments = super().reduce(compiled)
        return *parts, tuple(one for one in environments if one.consts)


@cache
def levels() -> tuple[str, ...]:
    """Return the levels of the processor whose kernels this process can run; it compiles for the last."""
    own = "-".join(numba.core.registry.cpu_target.target_context.codegen().magic_tuple())
    if numba.config.CPU_NAME == PORTABLE:
        return (_portable(),)
    features = llvmlite.binding.get_host_cpu_features()
    can = platform.machine() in ("x86_64", "AMD64") and all(features.get(name) for name in PORTABLE_FEATURES)
    return (_portable(), own) if can else (own,)


def _portable() -> str:
    return f"{PORTABLE}-{sys.platform}"


@cache
def _digest(kernel: Any) -> str:
    """Return a digest of the source compiled into a kernel, when it is first asked for: by then its module is read."""
    found = hashlib.sha256()
    for part in compiled_into(kernel):
        function = part.py_func
        constants = [f"{name}={_text(value)}" for name, value in _seen(function) if _is_constant(value)]
        code = _code(function.__code__, function.__doc__)
        told = (sorted(part.targetoptions.items()), function.__defaults__, constants, *code)
        found.update(repr(told).encode())
    return found.hexdigest()


def _seen(function: Callable[..., Any]) -> Iterator[tuple[str, Any]]:
    """Yield the objects that the names in a function represent outside it, and those of modules of the package."""
    names, scope = sorted(_names(function.__code__)), dict(function.__globals__)
    for name, cell in zip(function.__code__.co_freevars, function.__closure__ or (), strict=True):
        names, scope[name] = [*names, name], cell.cell_contents
    modules = [v for n in names if isinstance(v := scope.get(n), ModuleType) and v.__name__.startswith("bsm_mesh")]
    for space in (scope, *map(vars, modules)):
        yield from ((name, space[name]) for name in names if name in space)


def _names(code: CodeType) -> set[str]:
    inner = (_names(part) for part in code.co_consts if isinstance(part, CodeType))
    return set(code.co_names).union(*inner)


def _code(code: CodeType, words: str | None = None) -> tuple[Any, ...]:
    """Return the code of a function, without its docstring."""
    parts = [part for part in code.co_consts if words is None or part != words]
    constants = [_code(part) if isinstance(part, CodeType) else _text(part) for part in parts]
    return code.co_code, code.co_names, code.co_varnames, code.co_freevars, constants


def _is_constant(value: Any) -> bool:
    return not isinstance(value, Dispatcher | ModuleType)


def _text(value: Any) -> str:
    """Return a text that is the same in every process, of constants and of named tuples with their fields."""
    if isinstance(value, np.ndarray):
        return f"{value.dtype}{value.shape}{hashlib.sha256(value.tobytes()).hexdigest()}"
    if isinstance(value, frozenset):
        return repr(sorted(map(repr, value)))
    if callable(value):
        return f"{value.__module__}.{value.__qualname__}{getattr(value, '_fields', '')}"
    return repr(value)


def _fields(arguments: tuple[Any, ...]) -> Iterator[Any]:
    """Yield the fields of named tuples, which the texts of their types leave out."""
    for one in arguments:
        if isinstance(one, types.BaseNamedTuple):
            yield (one.instance_class.__qualname__, *one.fields)
        yield from _fields(tuple(getattr(one, "types", ())))

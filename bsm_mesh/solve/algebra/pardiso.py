"""MKL Pardiso through the `mkl` package: its phases apart, on the blocks as they are."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Sequence
from functools import cache
from importlib import metadata
from typing import Any

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.errors import ModelError, SingularMatrixError
from bsm_mesh.solve.algebra.block_matrix import BlockPattern

ANALYSE, FACTORIZE, SOLVE, RELEASE = 11, 22, 33, -1
_POSITIVE_DEFINITE, _STRUCTURALLY_SYMMETRIC = 2, 1
# [blocks]; below, threads wait more than they work, and refining takes what factors of single precision save.
LARGE = 5000
SHARES = 8  # into which a factorization is divided, whatever the number of threads: so that it changes no digit


def find_library(package: str, *stems: str) -> str | None:
    """Return the path of a dynamic library that a package installed, by the beginning of its name, or None."""
    try:
        files = metadata.files(package) or []
    except metadata.PackageNotFoundError:
        return None
    found = [file for file in files if file.name.startswith(stems) and not file.name.endswith(".lib")]
    return str(found[0].locate()) if found else None


@cache
def _library() -> ctypes.CDLL | None:
    """Return MKL's single dynamic library as the `mkl` package installed it, or None."""
    path = find_library("mkl", "libmkl_rt.so", "mkl_rt.")
    try:
        return None if path is None else ctypes.CDLL(path)
    except OSError:
        return None


def is_available() -> bool:
    """Return whether the `mkl` package is installed and loads."""
    return _library() is not None


class Pardiso:
    """MKL Pardiso on small blocks, LL^T or (whole patterns) LU; the analysis is kept between factorizations.

    Parameters
    ----------
    pattern : BlockPattern
        Upper triangle of the matrix.
    threads : int
        Threads to use; 0: as many as there are cores, where the matrix is large enough to gain by them.
    order : (n,) int32, optional
        Blocks in the order in which they are eliminated; by default METIS finds one, which takes five times as long
        and saves a tenth of a factorization.
    single : bool
        Factors of single precision: six tenths of the time, half the memory, and solutions of four digits.

    Raises
    ------
    ModelError
        If the `mkl` package is not installed.
    """

    name = "pardiso"
    _analysed = False  # also where __init__ raises, for __del__

    def __init__(
        self, pattern: BlockPattern, threads: int = 0, order: IntArray | None = None, *, single: bool = False
    ) -> None:
        self._mkl = self._load()
        self._pattern = pattern
        self._kind = _POSITIVE_DEFINITE if pattern.symmetric else _STRUCTURALLY_SYMMETRIC
        self._handle = np.zeros(64, dtype=np.int64)
        self._parameters = np.zeros(64, dtype=np.int32)
        self._parameters[0] = 1  # no defaults
        self._parameters[1] = 3  # nested dissection (METIS) on all threads
        self._parameters[4] = order is not None  # or the order given
        self._parameters[24] = 1  # one thread solves
        self._parameters[27] = single
        if not pattern.symmetric:  # of corrections, on every digit of which the way of Newton's method depends
            self._parameters[[1, 33]] = 2, SHARES  # on one thread METIS gives the same order every time
        self._parameters[34] = 1  # indices from 0
        self._data: FloatArray | None = None
        cores = os.cpu_count() or 1 if pattern.rows >= LARGE else 1
        self._threads, self._order = threads or cores, order
        self._precision = np.float32 if single else np.float64

    def _load(self) -> ctypes.CDLL:
        library = _library()
        if library is None:
            raise ModelError(
                "linear_solver = 'pardiso' needs the package mkl (x86-64): sh bootstrap.sh pardiso, or "
                "pip install mkl; or choose 'superlu'"
            )
        return library

    def factorize(self, data: FloatArray) -> None:
        """Factorize the values (n_places, axes, axes); the first call analyses the pattern too."""
        self._data = np.ascontiguousarray(data, dtype=self._precision)
        if not self._analysed:
            self._parameters[36] = data.shape[1]  # numbers a block
            self._call(ANALYSE)
            self._analysed = True
        self._call(FACTORIZE)

    def solve(self, right_side: FloatArray) -> FloatArray:
        """Return the solution (n, axes)."""
        b: FloatArray = np.ascontiguousarray(right_side, dtype=self._precision)
        x = np.empty_like(b)
        self._call(SOLVE, b, x)
        return x.astype(float, copy=False)

    def close(self) -> None:
        """Release Pardiso's memory."""
        if self._analysed and not sys.is_finalizing():  # then ctypes is gone already, and the memory soon
            self._call(RELEASE)
            self._analysed = False
        self._data = None

    def __del__(self) -> None:
        self.close()

    def _call(self, phase: int, b: FloatArray | None = None, x: FloatArray | None = None) -> None:
        error = self._run(phase, b, x)
        if error == -2:
            raise MemoryError("Pardiso: not enough memory for the factors")
        if error == -4 or (error and phase == FACTORIZE):  # numbers too far apart end in other errors
            raise SingularMatrixError(f"Pardiso found no positive pivot, error {error}")
        if error:
            raise RuntimeError(f"Pardiso failed with error {error} in phase {phase}")

    def _run(self, phase: int, b: FloatArray | None, x: FloatArray | None) -> int:
        """Return Pardiso's error code after a phase."""
        error = ctypes.c_int(0)
        self._mkl.MKL_Set_Num_Threads(ctypes.c_int(self._threads))
        self._mkl.pardiso(*self._arguments(phase, b, x), ctypes.byref(error))
        return error.value

    def _arguments(self, phase: int, b: FloatArray | None, x: FloatArray | None) -> list[Any]:
        """Return what Pardiso is called with, but for the error code."""
        pattern = self._pattern.row_start, self._pattern.column
        return arguments(
            self._handle,
            self._kind,
            phase,
            self._pattern.rows,
            self._parameters,
            (self._data, *pattern, self._order, b, x),
        )


def arguments(
    handle: IntArray, kind: int, phase: int, rows: int, parameters: IntArray, arrays: Sequence[np.ndarray | None]
) -> list[Any]:
    """Return the arguments that Pardiso's calls have in common; `arrays`: values, row starts, columns, order, b, x."""
    one, silent = ctypes.c_int(1), ctypes.c_int(0)
    values, row_start, column, order, b, x = (_pointer(array) for array in arrays)
    numbers = [ctypes.byref(ctypes.c_int(number)) for number in (1, 1, kind, phase, rows)]
    system = [_pointer(handle), *numbers, values, row_start, column, order]
    return [*system, ctypes.byref(one), _pointer(parameters), ctypes.byref(silent), b, x]


def _pointer(array: np.ndarray | None) -> ctypes.c_void_p | None:
    return None if array is None else array.ctypes.data_as(ctypes.c_void_p)

"""MKL Pardiso through the `mkl` package: its phases apart, on the 3 x 3 blocks as they are."""

from __future__ import annotations

import ctypes
import os
import sys
from functools import cache
from importlib import metadata

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.errors import ModelError, SingularMatrixError
from bsm_mesh.solve.pattern import BlockPattern

_ANALYSE, _FACTORIZE, _SOLVE, _RELEASE = 11, 22, 33, -1
_POSITIVE_DEFINITE, _STRUCTURALLY_SYMMETRIC = 2, 1
WORTH_THREADS = {_ANALYSE: 3000, _FACTORIZE: 3000, _SOLVE: 30_000}  # blocks: below, threads wait more than they work


@cache
def _library() -> ctypes.CDLL | None:
    """Return MKL's single dynamic library as the `mkl` package installed it, or None."""
    try:
        files = metadata.files("mkl") or []
    except metadata.PackageNotFoundError:
        return None
    for file in files:
        if file.name.startswith(("libmkl_rt.so", "mkl_rt.")) and not file.name.endswith(".lib"):
            try:
                return ctypes.CDLL(str(file.locate()))
            except OSError:
                return None
    return None


def is_available() -> bool:
    """Return whether the `mkl` package is installed and loads."""
    return _library() is not None


class Pardiso:
    """MKL Pardiso on 3 x 3 blocks, LL^T or (whole patterns) LU; the analysis is kept between factorizations.

    Parameters
    ----------
    pattern : BlockPattern
        Upper triangle of the matrix.
    threads : int
        Threads to use; 0: as many as there are cores, where the matrix is large enough to gain by them.
    order : (n,) int32, optional
        Blocks in the order in which they are eliminated; by default METIS finds one, which takes five times as long
        and saves a tenth of a factorization.

    Raises
    ------
    ModelError
        If the `mkl` package is not installed.
    """

    name = "pardiso"
    _analysed = False  # also where __init__ raises, for __del__

    def __init__(self, pattern: BlockPattern, threads: int = 0, order: IntArray | None = None) -> None:
        library = _library()
        if library is None:
            raise ModelError(
                "linear_solver = 'pardiso' needs the package mkl (x86-64): pip install 'bsm-mesh[pardiso]'; "
                "or choose 'superlu'"
            )
        self._mkl = library
        self._pattern = pattern
        self._kind = _POSITIVE_DEFINITE if pattern.symmetric else _STRUCTURALLY_SYMMETRIC
        self._handle = np.zeros(64, dtype=np.int64)
        self._parameters = np.zeros(64, dtype=np.int32)
        self._parameters[0] = 1  # no defaults
        self._parameters[1] = 3  # nested dissection (METIS) on all threads
        self._parameters[4] = order is not None  # or the order given
        self._parameters[34] = 1  # indices from 0
        self._parameters[36] = 3  # 3 x 3 blocks
        self._data: FloatArray | None = None
        self._threads, self._order = threads, order

    def factorize(self, data: FloatArray) -> None:
        """Factorize the values (n_places, 3, 3); the first call analyses the pattern too."""
        self._data = np.ascontiguousarray(data)
        if not self._analysed:
            self._call(_ANALYSE)
            self._analysed = True
        self._call(_FACTORIZE)

    def solve(self, right_side: FloatArray) -> FloatArray:
        """Return the solution (n, 3)."""
        b = np.ascontiguousarray(right_side)
        x = np.empty_like(b)
        self._call(_SOLVE, b, x)
        return x

    def close(self) -> None:
        """Release Pardiso's memory."""
        if self._analysed and not sys.is_finalizing():  # then ctypes is gone already, and the memory soon
            self._call(_RELEASE)
            self._analysed = False
        self._data = None

    def __del__(self) -> None:
        self.close()

    def _threads_for(self, phase: int) -> int:
        worth_it = self._pattern.rows >= WORTH_THREADS.get(phase, 0)
        return self._threads or (os.cpu_count() or 1 if worth_it else 1)

    def _call(self, phase: int, b: FloatArray | None = None, x: FloatArray | None = None) -> None:
        error = ctypes.c_int(0)
        self._mkl.MKL_Set_Num_Threads(ctypes.c_int(self._threads_for(phase)))
        one, message_level = ctypes.c_int(1), ctypes.c_int(0)
        self._mkl.pardiso(
            _pointer(self._handle),
            ctypes.byref(one),
            ctypes.byref(one),
            ctypes.byref(ctypes.c_int(self._kind)),
            ctypes.byref(ctypes.c_int(phase)),
            ctypes.byref(ctypes.c_int(self._pattern.rows)),
            _pointer(self._data),
            _pointer(self._pattern.row_start),
            _pointer(self._pattern.column),
            _pointer(self._order),
            ctypes.byref(one),
            _pointer(self._parameters),
            ctypes.byref(message_level),
            _pointer(b),
            _pointer(x),
            ctypes.byref(error),
        )
        if error.value == -2:
            raise MemoryError("Pardiso: not enough memory for the factors")
        if error.value == -4 or (error.value and phase == _FACTORIZE):  # numbers too far apart end in other errors
            raise SingularMatrixError(f"Pardiso found no positive pivot, error {error.value}")
        if error.value:
            raise RuntimeError(f"Pardiso failed with error {error.value} in phase {phase}")


def _pointer(array: np.ndarray | None) -> ctypes.c_void_p | None:
    return None if array is None else array.ctypes.data_as(ctypes.c_void_p)

"""MKL's Pardiso for clusters: the factors lie spread over MPI ranks, on one machine or many.

The first rank does everything else; the others wait in `ranks` and take part in every factorization and solution. Start
with ``mpiexec -n 4 python -m bsm_mesh.commands.mpi run model.toml``, or in a script of your own::

    with ranks() as first:
        if first:
            results = bsm.run(model, bsm.Options(linear_solver="cluster"))
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from itertools import count
from typing import Any, NamedTuple

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.errors import ModelError
from bsm_mesh.solve.algebra.block_matrix import BlockPattern
from bsm_mesh.solve.algebra.pardiso import RELEASE, Pardiso, arguments, find_library

NEEDS = (
    "linear_solver = 'cluster' needs the packages mkl, mpi4py and an MPI library such as mpich (Linux on x86-64): "
    "pip install mkl mpi4py mpich"
)
LIBRARIES = ("libmkl_core.so", "libmkl_intel_thread.so", "libmkl_intel_lp64.so")
_helped = False  # whether the other ranks wait in `ranks`


class _Call(NamedTuple):
    """A phase of a solver, as the first rank tells it to the others."""

    solver: int
    kind: int
    phase: int
    rows: int
    parameters: IntArray
    threads: int


@cache
def _communicator() -> Any:
    """Return MPI's communicator of all ranks.

    Raises
    ------
    ModelError
        If mpi4py or an MPI library is not there.
    """
    try:
        from mpi4py import MPI
    except (ImportError, RuntimeError) as error:
        raise ModelError(f"{NEEDS} ({error})") from error
    return MPI.COMM_WORLD


@cache
def _library() -> ctypes.CDLL:
    """Return MKL's library with the solver, bound to the MPI library that mpi4py has loaded.

    Raises
    ------
    ModelError
        If MKL is not there.
    """
    from mpi4py import MPI

    is_open = "Open MPI" in MPI.Get_library_version()
    blacs = f"libmkl_blacs_{'openmpi' if is_open else 'intelmpi'}_lp64.so"
    paths = [find_library("intel-openmp", "libiomp5.so"), *(find_library("mkl", stem) for stem in (*LIBRARIES, blacs))]
    if None in paths:
        raise ModelError(NEEDS)
    everywhere = ctypes.RTLD_GLOBAL | os.RTLD_LAZY  # these libraries find each other's functions, and MPI's, by name
    ctypes.CDLL("libmpi.so.40" if is_open else "libmpi.so.12", mode=everywhere)
    *_, solver, _ = [ctypes.CDLL(path, mode=everywhere) for path in paths]
    return solver


class ClusterPardiso(Pardiso):
    """MKL Pardiso whose factors are spread over all MPI ranks; used on the first of them, inside `ranks`.

    Parameters
    ----------
    pattern : BlockPattern
        The matrix, which the first rank holds whole.
    threads : int
        Threads of every rank; 0: the machine's cores divided by its ranks.

    Raises
    ------
    ModelError
        Outside `ranks`, where there are several, and where MPI or MKL is not installed.
    """

    name = "cluster"
    _numbers = count()

    def __init__(self, pattern: BlockPattern, threads: int = 0) -> None:
        super().__init__(pattern, threads)  # without an order: where one is given this solver returns nonsense
        self._number, self._threads = next(self._numbers), threads
        self._parameters[[1, 33]] = 3, 0  # nested dissection on all threads; sums in whatever order they end

    def _load(self) -> ctypes.CDLL:
        if _communicator().size > 1 and not _helped:
            raise ModelError(
                "linear_solver = 'cluster' needs the help of all MPI ranks; start with "
                "'mpiexec -n N python -m bsm_mesh.commands.mpi run MODEL', "
                "or see bsm_mesh.solve.algebra.pardiso_mpi.ranks"
            )
        return _library()

    def _run(self, phase: int, b: FloatArray | None, x: FloatArray | None) -> int:
        call = _Call(self._number, self._kind, phase, self._pattern.rows, self._parameters, self._threads)
        _communicator().bcast(call, root=0)
        return _take_part(call, self._arguments(phase, b, x))


def _take_part(call: _Call, given: list[Any]) -> int:
    """Return the error code of a phase in which all ranks take part."""
    comm, library = _communicator(), _library()
    error = ctypes.c_int(0)
    library.MKL_Set_Num_Threads(ctypes.c_int(call.threads or _fair_share()))
    library.cluster_sparse_solver(*given, ctypes.byref(ctypes.c_int(comm.py2f())), ctypes.byref(error))
    return error.value


@cache
def _fair_share() -> int:
    """Return the cores for every rank on this machine."""
    from mpi4py import MPI

    here = _communicator().Split_type(MPI.COMM_TYPE_SHARED)
    sharing: int = here.size
    here.Free()
    return max(1, (os.cpu_count() or 1) // sharing)


@contextmanager
def ranks() -> Iterator[bool]:
    """Give True on the first MPI rank; on the others help it to solve until its block ends, then give False."""
    comm = _communicator()
    _fair_share()  # all ranks together
    if comm.rank:
        _help(comm)
        yield False
        return
    global _helped
    _helped = True
    try:
        yield True
    finally:
        _helped = False
        comm.bcast(None, root=0)


def _help(comm: Any) -> None:
    """Take part in every phase that the first rank tells of, until it says that it is done."""
    handles: dict[int, IntArray] = {}
    while (call := comm.bcast(None, root=0)) is not None:
        handle = handles.setdefault(call.solver, np.zeros(64, dtype=np.int64))
        nothing = (None,) * 6  # the first rank holds matrix and right side
        _take_part(call, arguments(handle, call.kind, call.phase, call.rows, call.parameters, nothing))
        if call.phase == RELEASE:
            del handles[call.solver]

"""Meetings of threads after every cycle, inside compiled kernels: no thread begins the next before all have arrived.

Through Python a meeting costs a fifth of a millisecond, as much as a cycle of 3000 blocks. Here threads count
themselves in an array, by an atomic operation of the processor, and look until all have come. Between two looks they
let other threads run: on a busy machine a thread may have no processor.
"""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from bsm_mesh.arrays import IntArray
from bsm_mesh.compiled import njit

ARRIVED, GIVEN_UP, THREADS = 0, 1, 2  # of a meeting's numbers
CAN_YIELD = sys.platform != "win32"


def meeting_of(threads: int) -> IntArray:
    """Return the numbers of a meeting of so many threads, (3,) int64."""
    return np.array([0, 0, threads], dtype=np.int64)


def give_up(meeting: IntArray) -> None:
    """End the waiting of all threads: one has failed."""
    meeting[GIVEN_UP] = 1


def _element(context: Any, builder: Any, kind: Any, array: Any, index: int) -> Any:
    """Return the pointer to an element of an array, as compiled code has it."""
    found = context.make_array(kind)(context, builder, array)
    return cgutils.get_item_pointer(context, builder, kind, found, [context.get_constant(types.intp, index)])


@intrinsic
def _arrive(typing: Any, meeting: Any) -> Any:
    """Count one thread more."""

    def code(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        place = _element(context, builder, signature.args[0], given[0], ARRIVED)
        return builder.atomic_rmw("add", place, ir.Constant(ir.IntType(64), 1), "seq_cst")

    return types.int64(meeting), code


@intrinsic
def _arrived(typing: Any, meeting: Any) -> Any:
    """Return how many threads have arrived so far, as all see it."""

    def code(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        place = _element(context, builder, signature.args[0], given[0], ARRIVED)
        return builder.load_atomic(place, "seq_cst", 8)

    return types.int64(meeting), code


@intrinsic
def _yield(typing: Any) -> Any:
    """Let other threads run on this processor (POSIX)."""

    def code(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        kind = ir.FunctionType(ir.IntType(32), [])
        return builder.call(cgutils.get_or_insert_function(builder.module, kind, "sched_yield"), [])

    return types.int32(), code


@njit(nogil=True)
def meet(meeting: IntArray, times: int) -> bool:  # pragma: no cover - compiled
    """Wait until all threads of a meeting have come here so many times; return False where one has failed.

    All threads can then read the values written before.
    """
    if meeting[THREADS] == 1:
        return True
    _arrive(meeting)
    while _arrived(meeting) < times * meeting[THREADS]:
        if meeting[GIVEN_UP] != 0:
            return False
        if CAN_YIELD:
            _yield()
    return True

"""What is measured of a run: where its time goes, its factorizations, its peak memory."""

from __future__ import annotations

import functools
import importlib
import resource
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

WORK = {  # kind of work: functions of the program that do it; what they call of another kind counts there
    "contacts": (
        "bsm_mesh.contact.table:initial_contacts",
        "bsm_mesh.contact.search:detect_contacts",
        "bsm_mesh.contact.contact_set:gather_contacts",
    ),
    "assembly": (
        "bsm_mesh.solve.algebra.block_matrix:block_pattern",
        "bsm_mesh.solve.algebra.block_matrix:whole_pattern",
        "bsm_mesh.solve.algebra.block_matrix:fill_stiffness",
        "bsm_mesh.solve.algebra.block_matrix:constrain",
        "bsm_mesh.contact.force_kernels:fill_tangent",
    ),
    "factorization": (
        "bsm_mesh.solve.algebra.pardiso:Pardiso.factorize",
        "bsm_mesh.solve.algebra.superlu:SuperLU.factorize",
    ),
    "solution": ("bsm_mesh.solve.algebra.pardiso:Pardiso.solve", "bsm_mesh.solve.algebra.superlu:SuperLU.solve"),
    "motion": ("bsm_mesh.solve.motion.threads:advance_window",),
}
PARTS = (*WORK, "rest")


class Split:
    """Processor seconds by kind of work, and how many factorizations there were.

    Attributes
    ----------
    seconds : dict of str to float
        Of every kind in `PARTS` once `watch` is over.
    factorizations : int
        Calls of a linear solver's ``factorize``.
    total, processor : float [s]
        Wall time, and processor time of all threads, of what ran inside `watch`.
    """

    def __init__(self) -> None:
        self.seconds = dict.fromkeys(PARTS, 0.0)
        self.factorizations, self.total, self.processor = 0, 0.0, 0.0
        self._inner = [0.0]  # seconds of other kinds inside the functions that run now

    @contextmanager
    def watch(self) -> Iterator[None]:
        """Time what runs within; the functions of `WORK` are wrapped meanwhile."""
        restore = [self._wrap(kind, name) for kind, names in WORK.items() for name in names]
        began, work = time.perf_counter(), time.process_time()
        try:
            yield
        finally:
            self.total, self.processor = time.perf_counter() - began, time.process_time() - work
            self.seconds["rest"] = self.processor - self._inner[0]
            for undo in restore:
                undo()

    def _wrap(self, kind: str, name: str) -> Callable[[], None]:
        """Put a timed function in the place of a function, wherever it was imported; return what undoes that."""
        module_name, _, path = name.partition(":")
        owner: Any = importlib.import_module(module_name)
        *outer, last = path.split(".")
        for part in outer:
            owner = getattr(owner, part)
        plain = getattr(owner, last)

        @functools.wraps(getattr(plain, "py_func", plain))
        def timed(*given: Any, **keys: Any) -> Any:
            self.factorizations += kind == "factorization"
            self._inner.append(0.0)
            began = time.process_time()
            try:
                return plain(*given, **keys)
            finally:
                took = time.process_time() - began
                self.seconds[kind] += took - self._inner.pop()
                self._inner[-1] += took

        timed.signatures = getattr(plain, "signatures", ())  # the program asks whether it is compiled
        ours = [module for key, module in sys.modules.items() if key.startswith("bsm_mesh")]
        places = [owner] if outer else [module for module in ours if vars(module).get(last) is plain]
        for place in places:
            setattr(place, last, timed)

        def undo() -> None:
            for place in places:
                setattr(place, last, plain)

        return undo


def peak_memory() -> float:
    """Return the peak memory of this process [GB of 2^30 bytes]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024**2


@contextmanager
def timed(row: dict[str, Any], part: str) -> Iterator[None]:
    """Enter the processor seconds of what runs within under ``row["parts"][part]``."""
    began = time.process_time()
    yield
    row.setdefault("parts", {})[part] = time.process_time() - began

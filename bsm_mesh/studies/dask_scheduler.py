"""Runs of a study on the workers of a Dask cluster."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any
from uuid import uuid4

from bsm_mesh.errors import ModelError, one_line
from bsm_mesh.studies.sampling import Value
from bsm_mesh.studies.scheduler import Work, perform
from bsm_mesh.worker_pool import ATTEMPTS, Finished

WAITING = "20 s"  # for the scheduler's answer


@dataclass(frozen=True, slots=True)
class Dask:
    """Runs on the workers of a Dask cluster: they have this version of bsm-mesh, and see the files by the same names.

    A worker that dies loses its run to another one; a run that kills its workers is given up by Dask's own count.

    Attributes
    ----------
    address : str
        Of the scheduler, such as ``tcp://10.0.0.1:8786``.
    """

    address: str

    def run(self, work: Work, tasks: Mapping[int, Mapping[str, Value]]) -> Iterator[Finished]:
        """Return the runs as they end."""
        from distributed import as_completed

        with self._client() as client:
            _refuse_other_versions(client)
            name = f"bsm-mesh-{uuid4().hex[:8]}"
            runs = {
                client.submit(
                    perform, work, run, dict(values), key=f"{name}-{run}", pure=False, retries=ATTEMPTS - 1
                ): run
                for run, values in tasks.items()
            }
            try:
                for future in as_completed(list(runs)):
                    error = future.exception()
                    if error is None:
                        yield Finished(run=runs[future], answers=future.result())
                    else:
                        yield Finished(run=runs[future], answers=None, error=f"given up by Dask: {_told(error)}")
                    future.release()
            finally:
                client.cancel([future for future in runs if not future.done()])

    def _client(self) -> Any:
        try:
            from distributed import Client
        except ImportError:
            raise ModelError("--scheduler needs Dask: pip install distributed") from None
        try:
            return Client(self.address, timeout=WAITING)
        except (OSError, ValueError, TimeoutError) as error:
            raise ModelError(
                f"--scheduler {self.address}: no Dask scheduler answers ({_told(error)}); give the address that "
                "`dask scheduler` prints, such as tcp://10.0.0.1:8786"
            ) from None


def _told(error: BaseException) -> str:
    return one_line(f"{error}" or type(error).__name__)


def _version() -> str:
    from bsm_mesh.version import __version__

    return __version__


def _refuse_other_versions(client: Any) -> None:
    """Raise where a worker has another version of the program, or none: its digits may be others."""
    here = _version()
    for worker, there in client.run(_version, on_error="return").items():
        if there != here:
            has = f"has bsm-mesh {there}" if isinstance(there, str) else f"has no bsm-mesh ({there})"
            raise ModelError(f"the Dask worker {worker} {has}, and here it is {here}; install the same there")

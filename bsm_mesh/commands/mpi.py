"""The command line on MPI ranks: ``mpiexec -n 4 python -m bsm_mesh.commands.mpi run`` (linear solver ``cluster``)."""

from __future__ import annotations

from bsm_mesh.text.interruption import guarded


def main() -> None:
    """Run a command on the first rank, which reports an interruption; the others help it to solve."""
    guarded(_on_ranks, last=True, tell=False)


def _on_ranks() -> None:
    from bsm_mesh.commands.cli import main as run_command
    from bsm_mesh.solve.algebra.pardiso_mpi import ranks

    with ranks() as first:
        if first:
            run_command()


if __name__ == "__main__":
    main()

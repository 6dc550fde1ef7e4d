"""From which size on the program shares work among threads, as its constants say."""

from __future__ import annotations

from bsm_mesh.contact import search
from bsm_mesh.solve.algebra import pardiso
from bsm_mesh.solve.motion import threads
from examples.numbers.pages import Table, markdown


def shares() -> str:
    """Return a row for every kind of work that threads share."""
    rows = [
        ("factorization by Pardiso", f"{pardiso.LARGE} blocks", "all"),
        ("cycles of explicit motion", f"{2 * threads.AT_ONCE} contacts", f"one for {threads.AT_ONCE}"),
        ("search for contacts", f"more than {search.PAIRS_AT_ONCE} pairs of blocks", "two, whatever `threads` says"),
    ]
    return markdown(("work", "shared from", "threads"), rows)


TABLES = (Table(name="threads", page="docs/performance.md", make=shares, tolerance=0.0),)

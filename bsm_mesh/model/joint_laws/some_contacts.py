"""Some of all contacts, with numbers of their own."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Self

from bsm_mesh.arrays import IntArray


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class SomeContacts:
    """Some of all contacts; every field has a value of each.

    Attributes
    ----------
    rows : (h,) int64
        Theirs among all contacts.
    """

    rows: IntArray

    def of(self, number: IntArray) -> Self:
        """Return those that get a number (m,) of 0 or more, under it."""
        rows = number[self.rows]
        kept = rows >= 0
        values = {field.name: getattr(self, field.name)[kept] for field in fields(self)}
        return replace(self, **{**values, "rows": rows[kept]})

"""The numbers in a section of an MSH 4.1 file, text or binary."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt


class Kind(Enum):
    """Kind of a number in the file."""

    INT = "i4"
    SIZE = "size"
    DOUBLE = "f8"


class TruncatedError(Exception):
    """The file ends, or ceases to be numbers, before the section does."""


class Numbers(Protocol):
    """A section, taken number by number from its start."""

    def take(self, kind: Kind, count: int) -> npt.NDArray[Any]:
        """Return the next `count` numbers."""
        ...


@dataclass(slots=True)
class TextNumbers:
    """Numbers of a text section."""

    values: npt.NDArray[np.float64]
    position: int = 0

    @classmethod
    def of(cls, text: bytes) -> TextNumbers:
        """Return the numbers in `text`, up to the first thing that is none."""
        # Element and node tags pass through float64, which is exact up to 2^53.
        return cls(np.fromstring(text.decode("ascii", "replace"), dtype=np.float64, sep=" "))

    def take(self, kind: Kind, count: int) -> npt.NDArray[Any]:
        """Return the next `count` numbers."""
        if count < 0 or self.position + count > len(self.values):
            raise TruncatedError
        found = self.values[self.position : self.position + count]
        self.position += count
        if kind is Kind.DOUBLE:
            return found
        if not np.all(np.abs(found) < 2.0**53):  # no whole number any more, or none at all
            raise TruncatedError
        return found.astype(np.int64)


@dataclass(slots=True)
class BinaryNumbers:
    """Numbers of a binary section, which is read in place."""

    content: bytes
    position: int
    byte_order: str
    size_bytes: int

    def take(self, kind: Kind, count: int) -> npt.NDArray[Any]:
        """Return the next `count` numbers."""
        code = f"u{self.size_bytes}" if kind is Kind.SIZE else kind.value
        dtype = np.dtype(code).newbyteorder(self.byte_order)  # type: ignore[arg-type]
        end = self.position + count * dtype.itemsize
        if count < 0 or end > len(self.content):
            raise TruncatedError
        found = np.frombuffer(self.content, dtype, count, self.position)
        self.position = end
        return found.astype(np.float64 if kind is Kind.DOUBLE else np.int64)

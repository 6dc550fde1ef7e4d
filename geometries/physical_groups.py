"""The grammar of physical-group names, ``kind:name``: the contract between geometries and converters.

Surfaces have ``rock:gneiss`` and ``excavation:1`` (a surface may have both); curves have
``joint:J1``, ``boundary:bottom`` and ``bolt:B1``. Pure Python: neither Gmsh nor NumPy is needed.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class GroupKind(StrEnum):
    """Meaning of a physical group."""

    ROCK = "rock"
    EXCAVATION = "excavation"
    JOINT = "joint"
    BOUNDARY = "boundary"
    BOLT = "bolt"

    @property
    def dimension(self) -> int:
        """2 for groups of surfaces, 1 for groups of curves."""
        return 2 if self in (GroupKind.ROCK, GroupKind.EXCAVATION) else 1


@dataclass(frozen=True, slots=True, order=True)
class GroupName:
    """A parsed physical-group name.

    Attributes
    ----------
    kind : GroupKind
        Meaning of the group.
    name : str
        Which one, for example ``gneiss``.
    """

    kind: GroupKind
    name: str

    def __str__(self) -> str:
        """Return the text form, ``kind:name``."""
        return f"{self.kind.value}:{self.name}"


def parse_group_name(text: str) -> GroupName | None:
    """Return the parsed name, or None where `text` is not of the form ``kind:name``.

    Spaces around the two parts do not count; the kind may be written in capitals.

    Examples
    --------
    >>> parse_group_name("joint:J1")
    GroupName(kind=<GroupKind.JOINT: 'joint'>, name='J1')
    >>> parse_group_name("Schist") is None
    True
    """
    kind, colon, name = text.partition(":")
    kind, name = kind.strip().lower(), name.strip()
    if not colon or not name or kind not in {known.value for known in GroupKind}:
        return None
    return GroupName(GroupKind(kind), name)


def rock(name: str) -> str:
    """Return ``rock:name``, for a surface."""
    return str(GroupName(GroupKind.ROCK, name))


def excavation(name: str) -> str:
    """Return ``excavation:name``, for a surface that a stage removes."""
    return str(GroupName(GroupKind.EXCAVATION, name))


def joint(name: str) -> str:
    """Return ``joint:name``, for a curve."""
    return str(GroupName(GroupKind.JOINT, name))


def boundary(name: str) -> str:
    """Return ``boundary:name``, for a curve of the outline."""
    return str(GroupName(GroupKind.BOUNDARY, name))


def bolt(name: str) -> str:
    """Return ``bolt:name``, for a curve along a rockbolt."""
    return str(GroupName(GroupKind.BOLT, name))

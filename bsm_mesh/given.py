"""Fields of dataclasses that take more than they hold: a list where a tuple is kept, a number where three are."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Generic, TypeVar

if TYPE_CHECKING:
    Held = TypeVar("Held", covariant=True)
    Taken = TypeVar("Taken", contravariant=True)

    class Given(Generic[Held, Taken]):
        """Type of a field that is read as `Held` and may be given as `Taken`; type checkers see a descriptor."""

        def __get__(self, owner: object, kind: type | None = None) -> Held: ...
        def __set__(self, owner: object, value: Taken) -> None: ...

else:

    class Given:
        """The type that is held, as the program reads it from the field."""

        def __class_getitem__(cls, kinds: tuple[Any, Any]) -> Any:
            return kinds[0]


def by_default(value: Any) -> Any:
    """Return the default of such a field; its type is that of the field."""
    return value

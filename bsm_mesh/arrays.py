"""Array types, the rule that a dataclass owns its arrays read-only (in every process), and a hash of its content."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Iterator, Mapping
from types import CodeType, FunctionType
from typing import Any, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

from bsm_mesh.errors import ModelError, UnknownNameError, as_given, nearest, shortened

FloatArray: TypeAlias = npt.NDArray[np.float64]
IntArray: TypeAlias = npt.NDArray[np.signedinteger[Any]]
BoolArray: TypeAlias = npt.NDArray[np.bool_]

MAX_SUMMARY = 360  # characters: three lines of a wide terminal, five of a narrow one
ROUNDING = 1e-9  # part of a number that is far above what the solver's sums lose of it, and below all that is measured

Value = TypeVar("Value")
Owner = TypeVar("Owner")


class ReadOnlyMapping(Mapping[str, Value]):
    """A mapping that nobody can change; it can be pickled, which Python's own (`types.MappingProxyType`) cannot.

    A name that it does not have is a `bsm_mesh.ModelError` with the names that it has.

    Examples
    --------
    >>> ReadOnlyMapping({"top": 1})
    ReadOnlyMapping({'top': 1})
    """

    __slots__ = ("_content",)

    def __init__(self, content: Mapping[str, Value]) -> None:
        self._content = dict(content)

    def __getitem__(self, key: str) -> Value:
        try:
            return self._content[key]
        except KeyError:
            raise UnknownNameError(f"there is no {key!r}{nearest(str(key), map(str, self._content))}") from None

    def __contains__(self, key: object) -> bool:
        return key in self._content

    def get(self, key: str, default: Any = None) -> Any:
        """Return a value, or `default` without the search for names that are near."""
        return self._content.get(key, default)

    def __iter__(self) -> Iterator[str]:
        return iter(self._content)

    def __len__(self) -> int:
        return len(self._content)

    def __repr__(self) -> str:
        return f"ReadOnlyMapping({self._content})"

    def __reduce__(self) -> tuple[Any, ...]:
        return _mapping_again, (self._content,)


class Portable:
    """Base of a frozen dataclass with arrays: pickled, copied or sent to another process they are read-only again.

    Cached values derived from the fields (`functools.cached_property`) are left behind.
    """

    __slots__ = ()

    def __reduce__(self) -> tuple[Any, ...]:
        content = {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}  # type: ignore[arg-type]
        return _owner_again, (type(self), content)

    def __repr__(self) -> str:
        return summary_of(self)


def rounding_of(coordinates: FloatArray) -> float:
    """Return what computing points from coordinates, any shape, leaves: some units in the last place of the greatest.

    Examples
    --------
    >>> rounding_of(np.array([4.5e6])) < 2e-8  # a map's northing
    True
    """
    return 16 * float(np.finfo(np.float64).eps) * float(np.abs(coordinates).max(initial=0.0))


def summary_of(owner: object) -> str:
    """Return a dataclass in at most five lines of a terminal: arrays by type and shape, long values cut off.

    Examples
    --------
    >>> @dataclasses.dataclass
    ... class Forces:
    ...     name: str
    ...     force: FloatArray
    >>> summary_of(Forces("top", np.zeros((3, 2))))
    "Forces(name='top', force=float64 (3, 2))"
    """
    fields = dataclasses.fields(owner)  # type: ignore[arg-type]
    content = ", ".join(f"{field.name}={_in_short(getattr(owner, field.name))}" for field in fields)
    return f"{type(owner).__name__}({shortened(content, MAX_SUMMARY)})"


def _in_short(value: Any) -> str:
    return f"{value.dtype} {value.shape}" if isinstance(value, np.ndarray) else as_given(value)


def _owner_again(kind: type[Owner], content: dict[str, Any]) -> Owner:
    """Return a dataclass as it was; it was validated when it was made."""
    made = object.__new__(kind)
    for name, value in content.items():
        object.__setattr__(made, name, _read_only_again(value))
    return made


def _mapping_again(content: dict[str, Any]) -> ReadOnlyMapping[Any]:
    return ReadOnlyMapping({key: _read_only_again(value) for key, value in content.items()})


def _read_only_again(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        value.setflags(write=False)
    return value


def show_only(owner: object) -> None:
    """Replace a frozen dataclass's arrays by read-only views; their maker may still change them."""
    for field in dataclasses.fields(owner):  # type: ignore[arg-type]
        value = getattr(owner, field.name)
        if isinstance(value, np.ndarray) and value.flags.writeable:
            object.__setattr__(owner, field.name, _read_only_again(value.view()))


def read_only(values: npt.ArrayLike, dtype: npt.DTypeLike, shape: tuple[int | None, ...], name: str) -> Any:
    """Return a read-only C-ordered array of the given type; an array that nobody can write is not copied.

    Parameters
    ----------
    values : array_like
        The user's input.
    dtype : dtype
        Element type to convert to.
    shape : tuple
        Expected shape; None represents any length.
    name : str
        The field's name, for the message.

    Raises
    ------
    ModelError
        If `values` is not numeric or has another shape.
    """
    try:
        array = np.asarray(values)
        whole = np.issubdtype(np.dtype(dtype), np.integer)
        if array.size and (array.dtype.kind not in "biufO" or (whole and array.dtype.kind == "f")):
            raise TypeError
        if whole and array.size and (array.max() > np.iinfo(dtype).max or array.min() < np.iinfo(dtype).min):
            raise OverflowError
        frozen = array.dtype == dtype and not array.flags.writeable and array.flags.c_contiguous and array.base is None
        array = array if frozen else np.array(array, dtype=dtype, order="C")
    except (TypeError, ValueError, OverflowError):
        raise ModelError(f"{name}: not an array of {np.dtype(dtype).name} numbers") from None
    if array.ndim != len(shape) or any(want not in (None, have) for want, have in zip(shape, array.shape, strict=True)):
        wanted = " x ".join("n" if want is None else str(want) for want in shape)
        raise ModelError(f"{name}: shape {array.shape} where ({wanted}) is needed")
    array.setflags(write=False)
    return array


def own_array(owner: object, name: str, dtype: npt.DTypeLike, shape: tuple[int | None, ...]) -> None:
    """Replace a frozen dataclass's array field by a checked read-only copy (`read_only`)."""
    object.__setattr__(owner, name, read_only(getattr(owner, name), dtype, shape, f"{type(owner).__name__}.{name}"))


def content_hash(thing: Any) -> str:
    """Return the SHA-256 of a (nested) dataclass's content: equal models have equal digests.

    Fields with ``metadata={"in_hash": False}`` (derived or cosmetic) do not count, those with ``"given"``, which came
    after digests had been written, only where they are not None. An object
    that is no dataclass, such as a user's own joint law, counts by its class's name and its attributes.
    """
    state = hashlib.sha256()
    _feed(state, thing)
    return state.hexdigest()


def _feed(state: Any, thing: Any, within: tuple[int, ...] = ()) -> None:
    if dataclasses.is_dataclass(thing):
        state.update(type(thing).__name__.encode())
        for field in dataclasses.fields(thing):
            counts = field.metadata.get("in_hash", True)
            if counts and (counts != "given" or getattr(thing, field.name) is not None):
                state.update(field.name.encode())
                _feed(state, getattr(thing, field.name), within)
    elif isinstance(thing, np.ndarray):
        state.update(f"{thing.dtype.str}{thing.shape}".encode())
        state.update(np.ascontiguousarray(thing).data)
    elif isinstance(thing, Mapping):
        for key in sorted(thing):
            state.update(repr(key).encode())
            _feed(state, thing[key], within)
    elif isinstance(thing, tuple | list):
        state.update(f"({len(thing)}".encode())
        for part in thing:
            _feed(state, part, within)
    elif isinstance(thing, int | float | np.number) and not isinstance(thing, bool):
        state.update(float(thing).hex().encode())
    elif _shows_an_address(thing):
        if id(thing) not in within:
            for part in _content(thing):
                _feed(state, part, (*within, id(thing)))
    else:
        state.update(repr(thing).encode())


def _shows_an_address(thing: Any) -> bool:
    kind: Any = type(thing)
    return isinstance(thing, FunctionType) or kind.__repr__ is object.__repr__


def _content(thing: Any) -> tuple[Any, ...]:
    """Return the content that identifies a function or an object of a plain class."""
    if isinstance(thing, FunctionType):
        code = thing.__code__
        constants = tuple(part for part in code.co_consts if not isinstance(part, CodeType))
        kept = tuple(cell.cell_contents for cell in thing.__closure__ or ())
        return thing.__qualname__, code.co_code, constants, kept, thing.__defaults__
    named = [getattr(kind, "__slots__", ()) for kind in type(thing).__mro__]
    slots = [name for names in named for name in ([names] if isinstance(names, str) else names) if hasattr(thing, name)]
    return type(thing).__qualname__, {name: getattr(thing, name) for name in (*getattr(thing, "__dict__", ()), *slots)}

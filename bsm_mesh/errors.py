"""Exceptions for faulty input."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager

MAX_SHOWN = 12  # faults, or known names, in a message
MAX_NAMED = 3  # sentences on one matter in a note or a reason: a reader needs the first few
LEAST_PART = 4  # letters of a name that stand for a longer one
LONGEST = 60  # characters of a value in a message
NUMBER = re.compile(r"[-+]?\d[\d.]*(e[-+]?\d+)?")
# What moves the cursor, colours, hides or turns round text on a terminal: control characters but tab and newline, the
# separators of lines and paragraphs, the marks of writing direction; and bytes of file names that are no text.
UNPRINTABLE = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ufeff\ud800-\udfff]")


class InputError(ValueError):
    """The input cannot be used: every fault found, each with its place, rule and cure.

    Parameters
    ----------
    faults : str or sequence of str
        One sentence per fault.

    Attributes
    ----------
    faults : tuple of str
        The sentences, in the order in which they were found.
    """

    def __init__(self, faults: str | Sequence[str]) -> None:
        self.faults: tuple[str, ...] = (faults,) if isinstance(faults, str) else tuple(faults)
        super().__init__(self._text())

    def __reduce__(self) -> tuple[type[InputError], tuple[tuple[str, ...]]]:
        return type(self), (self.faults,)  # from another process too all faults, one by one

    def _text(self) -> str:
        if len(self.faults) == 1:
            return one_line(self.faults[0])
        kinds: dict[str, list[str]] = {}  # faults that differ in numbers alone are of one kind
        for fault in self.faults:
            kinds.setdefault(NUMBER.sub("#", fault), []).append(one_line(fault))
        lines = [line for faults in kinds.values() for line in _of_one_kind(faults)]
        shown = [f"  - {line}" for line in lines[:MAX_SHOWN]]
        if len(lines) > MAX_SHOWN:
            shown.append(f"  - and {len(lines) - MAX_SHOWN} more")
        return "\n".join([f"{len(self.faults)} faults:", *shown])


def _of_one_kind(faults: list[str]) -> list[str]:
    """Return faults that differ in numbers alone, a line each; of many the first, with their number and places."""
    if len(faults) <= MAX_NAMED:
        return faults
    places = list(dict.fromkeys(fault.partition(": ")[0] for fault in faults))[1:]
    named = ", ".join(places[:MAX_NAMED]) + (", ..." if len(places) > MAX_NAMED else "")
    return [f"{faults[0]} [{len(faults) - 1} more of this kind{': ' if named else ''}{named}]"]


NO_PANDAS = "to_pandas needs the Python package 'pandas'; install it: pip install pandas"


class ModelError(InputError):
    """A model cannot be analysed.

    Examples
    --------
    >>> import bsm_mesh as bsm
    >>> try:
    ...     bsm.Rock("gneiss", unit_weight=-1)
    ... except bsm.ModelError as error:
    ...     print(len(error.faults))
    1
    """


class UnknownNameError(ModelError, KeyError):
    """A mapping does not have a name; `KeyError` as well, as Python's mappings raise.

    Examples
    --------
    >>> str(UnknownNameError("there is no 'crest' (known: toe)"))
    "there is no 'crest' (known: toe)"
    """

    def __str__(self) -> str:
        """Return the text itself: that of `KeyError` is quoted."""
        return self._text()


class SingularMatrixError(ArithmeticError):
    """The stiffness matrix is singular: something can move without resistance."""


class MeshWarning(UserWarning):
    """A repair or an omission in a mesh; the message says what and how much."""


class ResultsWarning(UserWarning):
    """Something of a run is not written; the message says what and why."""


def raise_faults(faults: Sequence[str]) -> None:
    """Raise one `ModelError` for all collected faults; do nothing if there are none."""
    if faults:
        raise ModelError(faults)


@contextmanager
def placed(place: str) -> Iterator[None]:
    """Say of every fault raised within where it is."""
    try:
        yield
    except ModelError as error:
        raise ModelError([f"{place}: {fault}" for fault in error.faults]) from error


@contextmanager
def gathered(faults: list[str], place: str = "") -> Iterator[None]:
    """Add the faults of the `InputError` raised within to a list, each with its place."""
    try:
        yield
    except InputError as error:
        faults.extend(f"{place}: {fault}" if place else fault for fault in error.faults)


def printable(text: str) -> str:
    r"""Return a text that can be shown on a terminal: characters that would steer it are escaped.

    Examples
    --------
    >>> printable("\x1b[31mred\tor\nnot")
    '\\x1b[31mred\tor\nnot'
    """
    return UNPRINTABLE.sub(lambda found: found[0].encode("unicode_escape").decode(), text)


def one_line(text: str) -> str:
    r"""Return a printable text without its line ends: a fault or a name is one line, whatever a file puts in it.

    Examples
    --------
    >>> one_line("gneiss\nerror: none")
    'gneiss\\nerror: none'
    """
    return printable(text).replace("\n", "\\n")


def as_given(value: object) -> str:
    """Return a value for a message: as Python writes it, on one line, cut off where it is long.

    Examples
    --------
    >>> as_given("gneiss"), as_given(list(range(1000)))
    ("'gneiss'", '[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16...')
    """
    try:
        return shortened(" ".join(repr(value).split()))
    except ValueError:  # Python writes no whole number of thousands of digits
        return "a number of thousands of digits"


def shortened(text: str, most: int = LONGEST) -> str:
    """Return a text of at most so many characters, cut off where it is longer.

    Examples
    --------
    >>> shortened("gneiss, schist, granite", most=15)
    'gneiss, schi...'
    """
    return text if len(text) <= most else f"{text[: most - 3]}..."


def nearest(name: object, known: Iterable[str], most: int = MAX_SHOWN) -> str:
    """Return a hint such as ``"; did you mean 'top'? (known: bottom, top)"`` for an unknown name, or for no text.

    Examples
    --------
    >>> nearest("joint a", ["joint A", "joint B"])
    "; did you mean 'joint A'? (known: joint A, joint B)"
    >>> nearest("stress", ["histories", "principal_stresses"])
    "; did you mean 'principal_stresses'? (known: histories, principal_stresses)"
    """
    names = sorted(known)
    if not names:
        return " (there are none)"
    name = name if isinstance(name, str) else ""
    lowered = {each.lower(): each for each in names}  # capitals are the least of differences
    close = difflib.get_close_matches(name.lower(), lowered, n=1, cutoff=0.8)
    close += [each for each in lowered if len(name) >= LEAST_PART and name.lower() in each]
    close += difflib.get_close_matches(name.lower(), lowered, n=1, cutoff=0.5)
    hint = f"; did you mean '{lowered[close[0]]}'?" if close else ""
    listed = ", ".join(names[:most]) + (", ..." if len(names) > most else "")
    return f"{hint} (known: {listed})"


def named_stage(name: str) -> str:
    """Return a stage as sentences name it, without the word twice.

    Examples
    --------
    >>> named_stage("cut"), named_stage("stage 1")
    ('stage cut', 'stage 1')
    """
    return name if name.lower().startswith("stage") else f"stage {name}"


def of_stage(name: str, note: str) -> str:
    """Return a note with the stage that it is of; a note on the input that names a stage has no other.

    Examples
    --------
    >>> of_stage("cut", "1 block moved"), of_stage("initial", "stage 'cut' changes nothing")
    ('stage cut: 1 block moved', "stage 'cut' changes nothing")
    """
    return note if note.startswith("stage '") else f"{named_stage(name)}: {note}"


def counted(number: int, noun: str) -> str:
    """Return a number with its noun.

    Examples
    --------
    >>> counted(1, "block"), counted(0, "block")
    ('1 block', '0 blocks')
    """
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def numbered(noun: str, ids: Iterable[int], most: int = 8) -> str:
    """Return a noun with the numbers of its things.

    Examples
    --------
    >>> numbered("block", [3]), numbered("block", [3, 4, 17], most=2)
    ('block 3', 'blocks 3, 4, ... (3 in all)')
    """
    numbers = list(ids)
    return f"{noun}{'s' * (len(numbers) > 1)} {listing(numbers, most)}"


def crossing(reason: str) -> str:
    """Return the fault of an outline that is no simple polygon, by the reason that GEOS gives.

    Examples
    --------
    >>> crossing("Self-intersection[0 0.5]")
    'is no simple polygon: it crosses or touches itself at (0, 0.5); give its corners in their order round it'
    """
    kind, _, at = reason.rstrip("]").partition("[")
    if "elf-intersection" not in kind:
        return f"is no simple polygon: {reason}"
    where = place(float(value) for value in at.split())
    return f"is no simple polygon: it crosses or touches itself at {where}; give its corners in their order round it"


def place(point: Iterable[float]) -> str:
    """Return ``"(x, y)"`` in six digits, or to the millimetre where that takes more (on a national grid), up to 15.

    Less than a nanometre is 0.
    """
    parts = [0.0 if abs(x) < 1e-9 else x for x in point]
    return "(" + ", ".join(f"{x:.{min(15, max(6, len(f'{abs(x):.0f}') + 3))}g}" for x in parts) + ")"


def listing(ids: Iterable[int], most: int = 8) -> str:
    """Return ``"3, 4, 17, ... (120 in all)"``: the first few of many numbers."""
    numbers = [int(i) for i in ids]
    text = ", ".join(str(i) for i in numbers[:most])
    return text if len(numbers) <= most else f"{text}, ... ({len(numbers)} in all)"

"""Question and answer of a search."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Annotated

from bsm_mesh import doors
from bsm_mesh.errors import ModelError, raise_faults
from bsm_mesh.model.model import Model
from bsm_mesh.model.options import Options
from bsm_mesh.model.quantities import PROCESSES, TRIALS, WIDTH
from bsm_mesh.model.values import Rules
from bsm_mesh.results.movement import FAR
from bsm_mesh.results.results import Results
from bsm_mesh.safety.bound import Limit
from bsm_mesh.safety.bracket import Bracket, Verdict
from bsm_mesh.safety.criterion import Failure, of_size
from bsm_mesh.safety.driver import Found, Trial
from bsm_mesh.safety.mechanism import Mechanism, collapse_of, mechanism_of

FACTOR = "factor of safety"  # the quantity of strength reduction


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """How a factor is looked for.

    Attributes
    ----------
    tolerance : float
        Width of the bracket over the factor.
    failure : Failure
        What counts as failure.
    trials : int
        Most trials.
    processes : int
        Trials that run at the same time.
    """

    tolerance: Annotated[float, WIDTH] = 0.005
    failure: Failure = field(default_factory=Failure)
    trials: Annotated[int, TRIALS] = 40
    processes: Annotated[int, PROCESSES] = 1

    def __post_init__(self) -> None:
        rules = Rules("safety")
        rules.numbers(self)
        rules.a_thing("failure", self.failure, Failure)
        raise_faults(rules.faults)


@dataclass(frozen=True, eq=False, repr=False, slots=True, kw_only=True)
class Safety:
    """A factor of safety, or the limit of another number.

    Attributes
    ----------
    quantity : str
        The divided or varied quantity.
    stable, unstable : float or None
        The last value at which the model is stable, and the first at which it fails; None: none was found.
    undecided : tuple of float
        Values between them whose trials had no verdict: they count as neither.
    is_closed : bool
        Whether the bracket is as narrow as asked, without undecided values in it.
    limit : Limit
        The upper bound by limit analysis.
    trials : tuple of Trial
        The trials, by value.
    states : dict
        Results at `stable` and `unstable`.
    mechanism : Mechanism or None
        The failure at `unstable`.
    collapse : Mechanism or None
        The mechanism of the bound by limit analysis.
    stage : str
        The stage in question.
    start : str
        From when on, in words.
    changed : str
        The change, in words.
    reference : float or None
        Value of the state from which movement counts.
    spread : tuple of (str, Bracket)
        The brackets of other starts and of stiffer joints; none where it was not asked.
    notes : tuple of str
        Notes for a reader, a sentence each.
    unit : str
        Unit of the quantity; empty: none.
    beside : str
        Answer of limit analysis, where its bound lies beyond the bracket; empty: it does not.
    """

    quantity: str
    stable: float | None
    unstable: float | None
    undecided: tuple[float, ...]
    is_closed: bool
    limit: Limit
    trials: tuple[Trial, ...]
    states: dict[float, Results]
    mechanism: Mechanism | None
    collapse: Mechanism | None
    stage: str
    start: str
    changed: str
    reference: float | None
    spread: tuple[tuple[str, Bracket], ...] = ()
    notes: tuple[str, ...] = ()
    unit: str = ""
    beside: str = ""

    def __repr__(self) -> str:
        return f"Safety: {self}"

    def _repr_html_(self) -> str:
        """Return the answer as HTML for a notebook."""
        return doors.safety_html(self)

    @property
    def factor(self) -> float | None:
        """The answer: the last stable value."""
        return self.stable

    @property
    def is_decided(self) -> bool:
        """Whether undecided trials, or a budget that was spent, leave nothing open."""
        if self.stable is None or self.unstable is None:
            return all(trial.verdict is not Verdict.UNDECIDED for trial in self.trials)
        return self.is_closed

    @property
    def seconds(self) -> float:
        """Processor time of all trials."""
        return sum(trial.seconds for trial in self.trials)

    def __str__(self) -> str:
        """Return the answer in a sentence."""
        if self.stable is None:
            return f"{self.quantity}: none found; no trial was stable"
        stable = with_unit(self.stable, self.unit)
        if self.unstable is None:
            return f"{self.quantity}: beyond {stable}; no trial failed"
        text = f"{self.quantity} {stable}: stable there, unstable at {with_unit(self.unstable, self.unit)}"
        if self.undecided:
            text += f", undecided at {', '.join(with_unit(value, self.unit) for value in self.undecided)}"
        return f"{text}; {self.beside}" if self.beside else text


def with_unit(value: float, unit: str) -> str:
    """Return a value with four digits and its unit.

    Examples
    --------
    >>> with_unit(1.2345678, ""), with_unit(20e3, "Pa")
    ('1.235', '2e+04 Pa')
    """
    return f"{value:.4g} {unit}".rstrip()


def run_options(model: Model, options: Options | None, processes: int) -> Options:
    """Return how trials are solved: to the first failure, in one thread where several run at the same time.

    Raises
    ------
    ModelError
        For schemes that know no failure.
    """
    rules = Rules("safety")
    rules.a_thing("options", options, Options, optional=True)
    raise_faults(rules.faults)
    given = options or model.options or Options()
    if given.scheme != "continuation":
        raise ModelError(
            f"safety: in scheme = '{given.scheme}' nothing can fail; take scheme = 'continuation' in [solver]"
        )
    return replace(given, falls=replace(given.falls, on_fall="stop"), threads=1 if processes > 1 else given.threads)


def answer_of(found: Found, limit: Limit, quantity: str, stage: str, start: str, changed: str) -> Safety:
    """Return the result of a search as the record that is handed out."""
    return Safety(
        quantity=quantity,
        stable=found.bracket.stable,
        unstable=found.bracket.unstable,
        undecided=found.bracket.undecided,
        is_closed=found.is_closed,
        limit=limit,
        trials=found.trials,
        states=found.states,
        mechanism=mechanism_of(found, limit),
        collapse=collapse_of(found, limit),
        stage=stage,
        start=start,
        changed=changed,
        reference=found.reference,
    )


def notes_on(found: Found, settings: Settings) -> tuple[str, ...]:
    """Return notes for a reader of a bracket, a sentence each."""
    notes = []
    if found.bracket.stable_beyond:
        values = ", ".join(f"{value:.4g}" for value in found.bracket.stable_beyond)
        notes.append(f"stable again at {values}, beyond the first that fails: the answer is the first failure")
    if not found.is_closed and found.bracket.stable is not None and found.bracket.unstable is not None:
        why = "undecided trials are in it" if found.bracket.undecided else f"{settings.trials} trials were spent"
        notes.append(f"the bracket is wider than {100 * settings.tolerance:g} %: {why}")
    if found.reference_moved > FAR and found.bracket.stable is not None:
        part = 100 * found.reference_moved
        notes.append(
            f"in the reference state, {found.reference:.4g}, a block moved by {part:.3g} % of its size: the answer "
            "is that of where the blocks reached rest"
        )
    bad = next((trial for trial in found.trials if trial.value == found.bracket.unstable), None)
    if bad is not None and bad.status.is_stable:
        notes.append(f"at {bad.value:.4g} blocks move, and reach rest again after {of_size(bad.moved)}")
    return tuple(notes)

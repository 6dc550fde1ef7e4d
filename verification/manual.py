"""Tables of docs/verification.md and docs/equations.md, from the cases and the equations."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from functools import partial
from itertools import groupby

from examples.numbers.pages import Table, markdown
from verification.case import Case, in_words, value_in_words
from verification.convergence import draw, table
from verification.elsewhere import table as elsewhere
from verification.equations import EQUATIONS, Equation, file_of
from verification.registry import CASES, TOPICS, Topic
from verification.sources import KINDS, SOURCES

PAGE, EQUATIONS_PAGE, FRONT = "docs/verification.md", "docs/equations.md", "README.md"
INDEPENDENT = ("thesis", "book", "program")  # kinds of sources outside this project
ERRORS = 0.35  # relative: an error near rounding, or of a search that stops within a tolerance, is no number to keep


def cases_of(cases: Sequence[Case]) -> str:
    """Return the table of cases. Those of one quantity whose numbers another page has are a row together."""
    rows = []
    for (page, quantity), group in groupby(cases, key=lambda case: (case.page, case.quantity)):
        some = list(group)
        if page and len(some) > 1:
            names = f"{len(some)} cases `{some[0].name.partition('-')[0]}-...`"
            short = ", ".join(dict.fromkeys(SOURCES[case.source].short for case in some))
            worst = max(some, key=lambda case: case.error)
            what = f"{some[0].what.rpartition(': ')[2]}; the greatest error"
            rows.append((names, what, short, quantity, f"[there]({page})", "", _error(worst), _allowed(worst)))
            continue
        for case in some:
            told = (f"[there]({page})", "") if page else tuple(value_in_words(value) for value in case.answer)
            source = SOURCES[case.source].short
            rows.append((f"`{case.name}`", case.what, source, quantity, *told, _error(case), _allowed(case)))
    header = ("case", "what", "source", "quantity", "exact", "found", "error", "allowed")
    return markdown(header, rows)


def _error(case: Case) -> str:
    return ("right" if case.error == 0 else "wrong") if case.is_told_in_words else in_words(case.error)


def _allowed(case: Case) -> str:
    return f"{case.tolerance:.1e}".replace("e-0", "e-").replace(".0e", "e") if case.tolerance else "exact"


def topic_table(topic: Topic, *, slow: bool) -> str:
    """Return the table of the quick or of the slow cases of a topic."""
    return cases_of([case for case in topic.cases if case.is_slow == slow])


def summary() -> str:
    """Return how many cases there are of each kind of source, and the greatest part of an allowance that is used."""
    quick = [case for case in CASES.values() if not case.is_slow]
    kinds = Counter(SOURCES[case.source].kind for case in quick)
    used = {kind: max((case.error / case.tolerance for case in quick if case.tolerance
                       and SOURCES[case.source].kind == kind), default=0.0) for kind in KINDS}  # fmt: skip
    rows = [(words, str(kinds[kind]), f"{100 * used[kind]:.0f} %") for kind, words in KINDS.items()]
    slow = len(CASES) - len(quick)
    elsewhere = sum(kinds[kind] for kind in INDEPENDENT)
    told = (
        f"{len(quick)} quick cases from {len(SOURCES)} sources, and {slow} that take longer. Of the quick ones "
        f"{elsewhere} have their answer from the thesis, from books, or from other programs."
    )
    return f"{told}\n\n{markdown(('the answer is from', 'quick cases', 'largest error over the tolerance'), rows)}"


def front() -> str:
    """Return the three numbers of the README: cases, cases with an independent answer, largest error over allowance."""
    quick = [case for case in CASES.values() if not case.is_slow]
    independent = [case for case in quick if SOURCES[case.source].kind in INDEPENDENT]
    used = max(case.error / case.tolerance for case in independent if case.tolerance)
    return "\n".join(
        (
            f"- **{len(CASES)}** verification cases from {len(SOURCES)} sources.",
            f"- **{len(independent)}** of the {len(quick)} quick cases compare with the thesis, a book, a paper or "
            "another program.",
            f"- **{100 * used:.0f} %** is the largest error of these, as a part of the tolerance that its case states.",
        )
    )


def sources() -> str:
    """Return the list of sources."""
    return "\n".join(f"* {each.short} ({KINDS[each.kind]}): {each.text}." for each in SOURCES.values())


def _row(equation: Equation) -> tuple[str, ...]:
    holds = ", ".join(f"[`{name.partition(':')[2]}`](../{file_of(name)})" for name in equation.holds) or "-"
    proving = [case for case in CASES.values() if set(case.equations) & set(equation.each)]
    tests = [f"`{case.name}`" for case in proving]
    tests += [f"[{name.partition('::')[2]}](../tests/{name.partition('::')[0]})" for name in equation.tests]
    error = in_words(max(case.error for case in proving)) if proving else "-"
    return equation.numbers, equation.what, holds, ", ".join(tests) or "-", error, equation.note


def equations(chapter: str) -> str:
    """Return the table of a chapter's equations."""
    rows = [_row(equation) for equation in EQUATIONS if equation.each[0].partition(".")[0] == chapter]
    return markdown(("Eq.", "what", "held by", "proved by case, test", "error today", "departure"), rows)


TABLES: tuple[Table, ...] = (
    Table(name="verification-front", page=FRONT, make=front, tolerance=ERRORS),
    Table(name="verification-summary", page=PAGE, make=summary, tolerance=ERRORS),
    *(Table(name=f"verification-{topic.name}", page=PAGE, make=partial(topic_table, topic, slow=False), tolerance=0.02)
      for topic in TOPICS),
    *(Table(name=f"verification-{topic.name}-slow", page=PAGE, make=partial(topic_table, topic, slow=True),
            tolerance=0.02, is_slow=True) for topic in TOPICS if any(case.is_slow for case in topic.cases)),
    Table(name="verification-convergence", page=PAGE, make=table, tolerance=ERRORS, draw=draw),
    Table(name="verification-elsewhere", page=PAGE, make=elsewhere),
    Table(name="verification-sources", page=PAGE, make=sources),
    *(Table(name=f"equations-{chapter}", page=EQUATIONS_PAGE, make=partial(equations, chapter), tolerance=ERRORS)
      for chapter in "3456B"),
)  # fmt: skip

"""Files of users of other programs and of strangers, each with what is expected of it (docs/campaigns.md)."""

from __future__ import annotations

import pytest

from tools.campaigns.foreign import done
from tools.campaigns.place import place
from tools.campaigns.strangers import KINDS

pytestmark = pytest.mark.robust


SLOW = {"names", "forgeries"}  # they draw reports


@pytest.mark.parametrize("kind", [pytest.param(k, marks=[pytest.mark.slow] if k in SLOW else []) for k in KINDS])
def test_the_program_does_what_is_expected(kind: str) -> None:
    with place() as there:
        wrong = {
            given.name: (faults, told) for given in KINDS[kind]() for told, faults in [done(there, given)] if faults
        }
    assert wrong == {}

"""The message of a fault."""

import re

import pytest

import bsm_mesh as bsm


def fault(text):
    """Return the context in which a `ModelError` with a text must be raised."""
    return pytest.raises(bsm.ModelError, match=re.escape(text))

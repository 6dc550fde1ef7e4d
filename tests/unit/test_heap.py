"""Freed memory goes back where the C library can do that, and elsewhere nothing happens."""

import sys

import pytest

from bsm_mesh import heap


@pytest.fixture(autouse=True)
def _asked_anew():
    heap._trim.cache_clear()
    yield
    heap._trim.cache_clear()


def test_memory_is_given_back():
    heap.give_back()
    assert heap._trim.cache_info().currsize == 1


def test_nothing_is_called_on_other_systems(monkeypatch):
    monkeypatch.setattr(sys, "platform", "win32")
    heap.give_back()
    assert heap._trim() is None

"""Freed memory goes back where the C library can do that, before factorizations of large models."""

import platform
import sys

import pytest

import bsm_mesh as bsm
from bsm_mesh import heap
from bsm_mesh.solve.step import factorization as factors
from tests.scenes.large import tilted_wall


def test_all_that_is_free_is_given_back(monkeypatch):
    kept = []
    monkeypatch.setattr(heap, "_trim", lambda: kept.append)
    heap.give_back()
    assert kept == [0]


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="glibc's")
def test_glibc_can_do_that():
    assert heap._trim() is not None
    heap.give_back()


def test_nothing_is_called_on_other_systems(monkeypatch):
    monkeypatch.setattr(heap, "_trim", heap._trim.__wrapped__)  # which remembers no other system
    monkeypatch.setattr(sys, "platform", "win32")
    heap.give_back()
    assert heap._trim() is None


@pytest.mark.parametrize("large", [True, False])
def test_it_is_given_back_before_every_factorization_of_a_large_model(monkeypatch, large):
    model, seen, factorize = tilted_wall(30).model(), [], factors.Factors.factorize

    def watched(self, data):
        seen.append("factorized")
        return factorize(self, data)

    monkeypatch.setattr(factors.Factors, "factorize", watched)
    monkeypatch.setattr(factors, "WORTH_GIVING_BACK", model.blocks.count + (not large))
    monkeypatch.setattr(factors, "give_back", lambda: seen.append("given back"))
    bsm.run(model)
    assert seen.count("factorized") > 1
    assert seen.count("given back") == (seen.count("factorized") if large else 0)

"""Signals kept back: nothing is raised within, nothing is lost, and their handlers come back."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator
from types import FrameType

import pytest

from bsm_mesh.signals import signals_held

pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals")


class TakenError(Exception):
    """A signal was taken."""


def take(number: int, frame: FrameType | None) -> None:
    raise TakenError(signal.Signals(number).name)


@pytest.fixture(autouse=True)
def handlers() -> Iterator[None]:
    """Two signals that raise, and one that is ignored."""
    given = {signal.SIGINT: take, signal.SIGTERM: take, signal.SIGHUP: signal.SIG_IGN}
    before = {number: signal.signal(number, handler) for number, handler in given.items()}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


def test_the_first_is_taken_at_the_end() -> None:
    done = []

    def work() -> None:
        with signals_held():
            signal.raise_signal(signal.SIGTERM)
            done.append(1)
            signal.raise_signal(signal.SIGINT)
            done.append(2)

    with pytest.raises(TakenError, match="SIGTERM"):
        work()
    assert done == [1, 2]
    assert signal.getsignal(signal.SIGTERM) == signal.getsignal(signal.SIGINT) == take


def test_an_ignored_signal_stays_ignored() -> None:
    with signals_held():
        signal.raise_signal(signal.SIGHUP)
    assert signal.getsignal(signal.SIGHUP) == signal.SIG_IGN


def test_handlers_come_back_where_something_else_is_raised() -> None:
    with pytest.raises(KeyError), signals_held():
        raise KeyError
    with pytest.raises(TakenError):
        signal.raise_signal(signal.SIGINT)


def test_another_thread_has_nothing_to_keep_back() -> None:
    done = []

    def work() -> None:
        with signals_held():
            done.append(True)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert done == [True]

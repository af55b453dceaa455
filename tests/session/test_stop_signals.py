"""A signal ends what waits or runs, even where Python drops the exception of its handler."""

import os
import signal
import threading

import pytest

from palpate.base import stop_signals


@pytest.fixture(autouse=True)
def handlers():
    with stop_signals.handled():
        yield
    assert not stop_signals.came(), "the next command of this process is not ended by the signals of the last one"
    assert not stop_signals.ends_at_once()


class Finalised:
    """Sends a signal from its finaliser, where Python prints an exception and drops it."""

    def __init__(self, number):
        self.number = number

    def __del__(self):
        os.kill(os.getpid(), self.number)


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_dropped_exception_ends_a_run_and_a_wait(number):
    Finalised(number)  # no exception reaches this line
    assert stop_signals.came()
    stopped = threading.Event()
    with stop_signals.deferred(stopped):
        assert stopped.is_set()
    with pytest.raises(KeyboardInterrupt):
        stop_signals.wait(threading.Event())
    assert stop_signals.ends_at_once() == (number == signal.SIGTERM)


def test_signal_during_a_run_sets_its_event_and_no_other():
    stopped = threading.Event()
    with stop_signals.deferred(stopped):
        os.kill(os.getpid(), signal.SIGINT)
        assert stopped.wait(1.0)
    with stop_signals.deferred(stopped):
        assert not stopped.is_set()
    with pytest.raises(KeyboardInterrupt):
        os.kill(os.getpid(), signal.SIGINT)


def test_ignored_signal_stays_ignored():
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    with stop_signals.handled():
        os.kill(os.getpid(), signal.SIGHUP)
        assert not stop_signals.came()
    signal.signal(signal.SIGHUP, before)

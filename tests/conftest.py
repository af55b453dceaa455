"""Fixed seeds for every property test, so that failures are reproducible on all machines; one thread of BLAS each.

Tests run beside each other, and waiting threads of BLAS would take their cores.
"""

import faulthandler
import gc
import os
import signal
import threading
from collections import Counter

import pytest
from hypothesis import settings

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(name, "1")

for _signal, _default in ((signal.SIGINT, signal.default_int_handler), (signal.SIGHUP, signal.SIG_DFL)):
    if signal.getsignal(_signal) is signal.SIG_IGN:  # under nohup, and in the background of a script
        signal.signal(_signal, _default)  # processes that tests end inherit it

SLOW = ("viewer", "studies", "verify", "report", "cli", "package", "realtime")
"""Folders whose files take longest: they come first, so that the workers end at about the same time."""


def pytest_collection_modifyitems(items):
    items.sort(key=lambda item: item.nodeid.split("/")[1:2] not in [[name] for name in SLOW])


def pytest_collection():
    """Garbage collections while the tests are collected would pass over all those collected before."""
    gc.disable()


def pytest_collection_finish():
    """Garbage collections during the tests would pass over the thousands of tests and their modules; and they are
    seldom, because they took an eighth of the processor time."""
    gc.collect()
    gc.freeze()
    gc.enable()
    gc.set_threshold(20_000, 10, 10)


def pytest_sessionfinish(session):
    """A worker whose threads do not end after its last test prints them and exits. The main process keeps the
    processor time [s] of each folder in pytest's cache, where tools/tests.py finds it."""
    if hasattr(session.config, "workerinput"):
        threading.Thread(target=_end, daemon=True).start()
    elif _used and hasattr(session.config, "cache"):
        session.config.cache.set("palpate/processor_time", dict(_used))


def _end():
    """Exit a minute after the main thread, which may wait longer than that for the other workers."""
    threading.main_thread().join()
    faulthandler.dump_traceback_later(60.0, exit=True)


_used = Counter()  # processor time of each folder [s]
_began = [0.0]  # processor time when the present test began [s]


def _processor_time():
    """Processor time of this process and of its children that have ended [s]."""
    return sum(os.times()[:4])


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_logstart(nodeid):
    _began[:] = [_processor_time()]


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(call):
    report = yield
    if call.when == "teardown":
        report.user_properties.append(("processor_time", _processor_time() - _began[0]))
    return report


def pytest_runtest_logreport(report):
    if report.when == "teardown":
        folder = "/".join(report.nodeid.split("/")[:-1][:2])
        _used[folder] += dict(report.user_properties)["processor_time"]


settings.register_profile("palpate", derandomize=True, deadline=None)
settings.load_profile("palpate")


@pytest.fixture
def sweeps_in_process(monkeypatch):
    """Sweeps start no processes, whose imports take longer than a short study; tests/sweep judges processes."""
    from palpate.base.sweep import local, run

    monkeypatch.setattr(local, "run", lambda work, todo, workers=None: run._serial(work, todo))


@pytest.fixture
def unarranged_figures(monkeypatch):
    """Figures are drawn and saved, but not arranged, which takes most of their time; tests/report arranges them."""
    monkeypatch.setattr("matplotlib.figure.Figure.get_layout_engine", lambda figure: None)


@pytest.fixture
def without_figures(monkeypatch):
    """Reports hold the descriptions of their figures, whose drawing tests/report checks: it takes seconds a page."""
    monkeypatch.setattr("palpate.base.plotting.style.picture", lambda draw, alt: f"<p>{alt}</p>")

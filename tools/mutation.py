"""Plants a fault in a module and runs the tests that can notice it: the part of `tools/mutants.py` that judges.

The tests run once without a fault under a tracer, which notes the lines that each test executes. A fault in a line of a
function is then given to the tests that execute its statement, cheapest first; without such a test it has survived. A
fault in a statement executed by imports is given to all tests, those that use its module first.

Tests that share a fixture of module or session scope share its lines and each other's: the first of them may compute
and keep what another asserts. The caches of functions are cleared before each test for the same reason.
"""

from __future__ import annotations

import ast
import contextlib
import functools
import io
import math
import os
import pickle
import resource
import signal
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import FrameType
from typing import Any

import pytest

START = 10.0
"""Processor time that starting pytest and collecting tests may take on a slow machine [s]."""
Line = tuple[str, int]
"""A file and a line of it."""


@dataclass(frozen=True)
class Mutant:
    """One changed place of one file."""

    path: Path
    line: int
    operator: str
    source: str
    """Text of the whole file with the fault."""


@dataclass
class Map:
    """Lines executed by each test (`node id`) and by imports, and the cost of each test."""

    tests: dict[str, set[Line]] = field(default_factory=dict)
    imports: set[Line] = field(default_factory=set)
    cost: dict[str, float] = field(default_factory=dict)
    """Processor time of a test with the fixtures of module and session scope that it needs [s]."""

    def tests_of(self, mutant: Mutant) -> list[str]:
        """The tests that can notice the fault, cheapest first."""
        path = str(mutant.path)
        lines = {(path, line) for line in statement(mutant.path.read_text(encoding="utf-8"), mutant.line)}
        order = sorted(self.tests, key=lambda test: (self.cost[test], test))
        direct = [test for test in order if self.tests[test] & lines]
        if not self.imports & lines:
            return direct
        users = [test for test in order if any(name == path for name, _ in self.tests[test]) and test not in direct]
        return direct + users + [test for test in order if test not in direct and test not in users]


def statement(text: str, line: int) -> set[int]:
    """Lines of the innermost statement around the line, without the statements inside it."""
    owner: dict[int, ast.stmt] = {}
    for node in ast.walk(ast.parse(text)):  # outer statements come first
        if isinstance(node, ast.stmt):
            first = min([node.lineno, *(one.lineno for one in getattr(node, "decorator_list", []))])
            owner |= dict.fromkeys(range(first, (node.end_lineno or first) + 1), node)
    return {one for one, node in owner.items() if node is owner.get(line)}


class Tracer:
    """A plugin of pytest that fills a `Map` with the lines of the given files."""

    def __init__(self, paths: set[str], packages: frozenset[str]) -> None:
        self.paths, self.packages, self.map = paths, packages, Map()
        self.now = self.map.imports
        self.shared: dict[int, set[Line]] = {}  # lines of each fixture of module or session scope
        self.spent: dict[int, float] = {}  # processor time of these fixtures
        self.used: dict[str, list[int]] = {}  # their use by tests
        self.kept: list[object] = []  # so that no id is given twice

    def trace(self, frame: FrameType, event: str, _: object) -> Any:
        """Note the lines of the files; all other frames are left alone."""
        name = frame.f_code.co_filename
        if name not in self.paths:
            return None
        self.now.add((name, frame.f_lineno))
        return self.trace

    @contextlib.contextmanager
    def into(self, lines: set[Line]) -> Iterator[None]:
        """While this lasts, executed lines are added to the set."""
        before, self.now = self.now, lines
        try:
            yield
        finally:
            self.now = before

    @contextlib.contextmanager
    def tracing(self) -> Iterator[None]:
        """While this lasts, lines are noted; those of imports are noted as such."""
        execute = SourceFileLoader.exec_module

        def importing(loader: SourceFileLoader, module: Any) -> None:
            with self.into(self.map.imports):
                execute(loader, module)

        SourceFileLoader.exec_module = importing  # type: ignore[method-assign]
        threading.settrace(self.trace)
        sys.settrace(self.trace)
        try:
            yield
        finally:
            sys.settrace(None)
            threading.settrace(None)  # type: ignore[arg-type]
            SourceFileLoader.exec_module = execute  # type: ignore[method-assign]

    def forget(self) -> None:
        """Clear the caches of functions: what one test left there, another one would not compute."""
        for name, module in list(sys.modules.items()):
            if name.split(".")[0] in self.packages:
                for one in vars(module).values():
                    if isinstance(one, functools._lru_cache_wrapper):
                        one.cache_clear()

    @pytest.hookimpl(wrapper=True)
    def pytest_fixture_setup(self, fixturedef: Any) -> Iterator[None]:
        """Note the lines and the time of a fixture that tests share."""
        if fixturedef.scope == "function" or fixturedef.func.__module__.startswith("_pytest"):
            return (yield)
        self.forget()
        self.kept.append(fixturedef)
        begin, key = cpu_time(), id(fixturedef)
        with self.into(self.shared.setdefault(key, set())):
            made = yield
        self.spent[key] = self.spent.get(key, 0.0) + cpu_time() - begin
        return made

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: Any) -> Iterator[None]:
        """Note the lines and the time of a test."""
        self.forget()
        begin = cpu_time()
        with self.into(self.map.tests.setdefault(item.nodeid, set())):
            done = yield
        self.map.cost[item.nodeid] = cpu_time() - begin
        definitions = [one for found in item._fixtureinfo.name2fixturedefs.values() for one in found]
        self.used[item.nodeid] = [id(one) for one in definitions if id(one) in self.shared]
        return done

    def result(self) -> Map:
        """The map, with what tests share."""
        for key, lines in self.shared.items():
            together = [test for test, used in self.used.items() if key in used]
            lines |= set().union(*(self.map.tests[test] for test in together))
            longest = max((self.map.cost[test] for test in together), default=0.0)
            for test in together:
                self.map.tests[test] |= lines
                self.map.cost[test] = max(self.map.cost[test], self.spent[key], longest)
        return self.map


class Chosen:
    """A plugin of pytest that runs the given tests in the given order."""

    def __init__(self, tests: list[str]) -> None:
        self.tests = tests

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[Any]) -> None:
        """Keep these tests."""
        found = {item.nodeid: item for item in items}
        items[:] = [found[test] for test in self.tests]


def cpu_time() -> float:
    """Processor time of this process and its children so far [s]."""
    return sum(os.times()[:4])


@contextlib.contextmanager
def planted(mutant: Mutant | None) -> Iterator[None]:
    """While this lasts, importing the mutant's file executes the mutant."""
    get_code = SourceFileLoader.get_code

    def changed(self: SourceFileLoader, fullname: str) -> object:
        if mutant and Path(self.path) == mutant.path:
            return compile(mutant.source, self.path, "exec", dont_inherit=True)
        return get_code(self, fullname)

    SourceFileLoader.get_code = changed  # type: ignore[method-assign, assignment]
    try:
        yield
    finally:
        SourceFileLoader.get_code = get_code  # type: ignore[method-assign]


@dataclass(frozen=True)
class Suite:
    """The tests of a group: files and folders, and further arguments of pytest."""

    root: Path
    files: list[str]
    arguments: list[str]
    packages: frozenset[str]
    """Packages whose cached results each test computes anew."""

    def map_lines(self, paths: set[Path]) -> tuple[bool, Map]:
        """Run all tests without a fault; whether they pass, and which lines of the files each of them executes."""
        tracer = Tracer({str(path) for path in paths}, self.packages)
        with tempfile.TemporaryFile() as out:
            passed, _ = _forked(lambda: _traced(self, tracer, out), 600.0)
            out.seek(0)
            return passed, pickle.load(out) if passed else Map()

    def survives(self, mutant: Mutant, map_: Map | None) -> tuple[bool, float]:
        """Whether the tests pass with the mutant, and the processor time [s]; without a map all tests run."""
        if map_ is None:
            return _forked(lambda: self._run(self.files, mutant, []), 600.0)
        tests = map_.tests_of(mutant)
        if not tests:
            return True, 0.0
        files = sorted({test.split("::")[0] for test in tests})
        limit = START + 3.0 * sum(map_.cost[test] for test in tests)
        return _forked(lambda: self._run(files, mutant, [Chosen(tests)]), limit)

    def _run(self, files: list[str], mutant: Mutant | None, plugins: list[object]) -> int:
        os.chdir(self.root)
        with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryDirectory() as base, planted(mutant):
            os.dup2(out.fileno(), 1)
            os.dup2(out.fileno(), 2)
            with contextlib.redirect_stdout(io.StringIO()):
                options = ["-x", "-q", "-p", "no:cacheprovider", f"--rootdir={self.root}", f"--basetemp={base}/t"]
                return int(pytest.main([*options, *self.arguments, *files], plugins))


def _traced(suite: Suite, tracer: Tracer, out: Any) -> int:
    with tracer.tracing():
        status = suite._run(suite.files, None, [tracer])
    pickle.dump(tracer.result(), out)
    out.flush()
    return status


def _forked(run: Callable[[], int], cpu_limit: float) -> tuple[bool, float]:
    """Whether `run` returns 0 in a process of its own within the time, and its processor time [s].

    It runs again if the wall time ended it, because the process may have been stopped from outside.
    """
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    status = _status(run, cpu_limit)
    if os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGALRM:
        status = _status(run, cpu_limit)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return status == 0, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def _status(run: Callable[[], int], cpu_limit: float) -> int:
    pid = os.fork()
    if pid == 0:
        status = 70
        try:
            signal.signal(signal.SIGINT, signal.default_int_handler)
            resource.setrlimit(resource.RLIMIT_CPU, (math.ceil(cpu_limit), math.ceil(cpu_limit) + 5))
            signal.alarm(math.ceil(20 * cpu_limit))
            status = run()
        finally:
            os._exit(status)
    return os.waitpid(pid, 0)[1]

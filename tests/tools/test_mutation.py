"""The judge of mutants on a small package: it finds faults that tests notice, and reports those that none notices."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

TOOLS = Path(__file__).parents[2] / "tools"
MODULE = """
import functools

LIMIT = 3

def double(x):
    return 2 * x

def unasserted(x):
    return x + 1

def unused(x):
    return x - 1

def countdown(x):
    while x > 0:
        x -= 1
    return x

def branch(x):
    if (
        x
        > LIMIT
    ):
        return "above"
    return "below"

@functools.cache
def slow(x):
    return x * x

class Kept:
    value = None

    def get(self):
        if self.value is None:
            self.value = double(10) + 1
        return self.value
"""
TESTS = """
import pytest

@pytest.fixture(scope="module")
def kept():
    from faulty import Kept
    return Kept()

def test_first_use(kept):
    assert kept.get() != 0

def test_second_use(kept):
    assert kept.get() == 21

def test_unasserted():
    from faulty import unasserted
    unasserted(1)

def test_countdown():
    from faulty import countdown
    assert countdown(3) == 0

def test_branch():
    from faulty import branch
    assert branch(4) == "above"

def test_slow_is_positive():
    from faulty import slow
    assert slow(3) > 0

def test_slow_is_a_square():
    from faulty import slow
    assert slow(3) == 9

def test_limit_is_stated():
    import faulty
    assert faulty.LIMIT == 3
"""
JUDGE = """
import json, sys
from pathlib import Path
sys.path[:0] = [sys.argv[1], sys.argv[2]]
import mutation
mutation.START = 0.5
root = Path(sys.argv[2])
module, suite = root / "faulty.py", mutation.Suite(
    root, ["test_faulty.py"], ["-c", "/dev/null"], frozenset(["faulty"])
)
text = module.read_text()
passed, lines = suite.map_lines({module})
out = {"passed": passed}
for old, new in json.loads(sys.argv[3]):
    line = text[: text.index(old)].count("\\n") + 1
    mutant = mutation.Mutant(module, line, "", text.replace(old, new))
    survived, cpu = suite.survives(mutant, lines)
    tests = [test.split("::")[1] for test in lines.tests_of(mutant)]
    out[new] = survived, tests, cpu, suite.survives(mutant, None)[0] if new in sys.argv[4:] else survived
print(json.dumps(out))
"""
FAULTS = {
    "2 * x": "2 / x",
    "x + 1": "x - 1",
    "x - 1": "x + 2",
    "while x > 0": "while x < 9",
    "> LIMIT": "<= LIMIT",
    "LIMIT = 3": "LIMIT = 2",
    "x * x": "x + x",
    "double(10) + 1": "double(10) + 2",
}

AGAIN = ["2 / x", "x - 1", "x + 2"]
"""Faults that are also given to all tests."""


@pytest.fixture(scope="module")
def judged(tmp_path_factory):
    """Verdict, tests, processor time and the verdict of all tests, by the text of the fault."""
    root = tmp_path_factory.mktemp("mutation")
    (root / "faulty.py").write_text(MODULE)
    (root / "test_faulty.py").write_text(TESTS)
    command = [sys.executable, "-c", JUDGE, str(TOOLS), str(root), json.dumps(list(FAULTS.items())), *AGAIN]
    alone = os.environ | {"PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=alone)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def test_tests_pass_without_a_fault(judged):
    assert judged["passed"]


def test_a_fault_that_a_test_asserts_is_killed(judged):
    """The operand of a condition stands in a line of its own; the endless loop ends by its processor time."""
    for fault, tests in (
        ("<= LIMIT", ["test_branch"]),
        ("while x < 9", ["test_countdown"]),
        ("double(10) + 2", ["test_first_use", "test_second_use"]),
        ("x + x", ["test_slow_is_a_square", "test_slow_is_positive"]),
        ("2 / x", ["test_first_use", "test_second_use"]),
    ):
        assert not judged[fault][0], fault
        assert sorted(judged[fault][1]) == tests, "also the test that reads what another one computed"


def test_a_fault_that_is_executed_but_not_asserted_survives(judged):
    assert judged["x - 1"][:2] == [True, ["test_unasserted"]]


def test_a_fault_that_no_test_executes_survives_without_a_run(judged):
    assert judged["x + 2"][:3] == [True, [], 0.0]


def test_a_fault_in_a_statement_of_the_module_is_given_to_all_tests(judged):
    survived, tests, *_ = judged["LIMIT = 2"]
    assert not survived
    assert len(tests) == 8
    assert tests[-1] == "test_limit_is_stated", "those that use the module come first"


def test_verdicts_are_those_of_all_tests(judged):
    assert [judged[fault][3] for fault in AGAIN] == [judged[fault][0] for fault in AGAIN] == [False, True, True]

"""The runner of long judges: which slice is next, what a stop keeps, and what the result says."""

import itertools
import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tools"))
import night  # noqa: E402
from night import Judge, Slice, next_judge, read_journal, share, table  # noqa: E402


def judge(name, asked=4.0, faults=(), code="", tried=0):
    """A judge whose command writes what it was asked for."""

    def command(before, step, out):
        text = f"import json; json.dump([{before}, {step}], open({str(out)!r}, 'w')); {code}"
        return [sys.executable, "-c", text]

    def read(found, step):
        count = {"tried": tried, "killed": tried - len(faults)} if tried else {"before": found[0]}
        return Slice("", found[1], list(faults), count)

    return Judge(name, asked, "cases", 2.0, command, read)


@pytest.fixture
def files(tmp_path):
    return tmp_path / "night" / "journal.jsonl", tmp_path / "night.json"


def test_the_judge_farthest_from_its_end_is_next():
    a, b = judge("a", 4.0), judge("b", 8.0)
    assert next_judge([a, b], [], set()) is a
    assert next_judge([a, b], [Slice("a", 2.0)], set()) is b
    assert next_judge([a, b], [Slice("a", 2.0), Slice("b", 6.0)], set()) is a
    assert next_judge([a, b], [Slice("a", 4.0), Slice("b", 8.0)], set()) is None
    assert next_judge([a, b], [], {"a"}) is b


def test_all_judges_run_whole_and_each_slice_follows_the_one_before(files):
    found = night.night([judge("a"), judge("b", 3.0)], 1.0, *files)
    assert [(row["judge"], row["ran"], row["fails"], row["verdict"]) for row in found] == [
        ("a", 4.0, False, "no fault"), ("b", 3.0, False, "no fault"),
    ]  # fmt: skip
    kept = read_journal(files[0])
    assert [(one.judge, one.count["before"], one.done) for one in kept] == [
        ("a", 0.0, 2.0), ("b", 0.0, 2.0), ("a", 2.0, 2.0), ("b", 2.0, 1.0),
    ]  # fmt: skip
    assert all(one.commit for one in kept)
    assert json.loads(files[1].read_text())["result"]["rows"] == found


def test_a_night_without_time_runs_nothing_and_says_so(files):
    found = night.night([judge("a")], 0.0, *files)
    assert found[0]["ran"] == 0.0
    assert table(found).endswith("0 of 1 judges ran whole; not run: a; fail: none")


def test_a_stopped_night_continues(files):
    one = judge("a")
    files[0].parent.mkdir()
    files[0].write_text('{"judge": "a", "done": 2.0, "commit": "old"}\n{"judge": "a", "do')  # cut off
    night.night([one], 1.0, *files)
    kept = read_journal(files[0])
    assert share(one, kept) == 1.0
    assert [kept[0].commit, kept[1].count["before"]] == ["old", 2.0]


def test_faults_are_kept_and_counted(files):
    found = night.night([judge("a", faults=["seed 3: a hole"], code="raise SystemExit(1)")], 1.0, *files)
    assert (found[0]["verdict"], found[0]["fails"], found[0]["faults"]) == ("2 faults", True, ["seed 3: a hole"] * 2)
    assert "fail: a" in table(found)


@pytest.mark.parametrize(("missed", "fails"), [(15, False), (16, True)])
def test_planted_faults_have_a_least_share(files, missed, fails):
    found = night.night([judge("a", asked=2.0, faults=["x"] * missed, tried=100)], 1.0, *files)
    assert found[0]["fails"] is fails
    assert found[0]["verdict"] == f"{100 - missed}% of the planted faults found (85% asked)"


def test_a_command_that_ends_badly_fails_and_the_others_go_on(files):
    found = night.night([judge("a", code="raise SystemExit('no compiler')"), judge("b", code="1")], 1.0, *files)
    assert [row["fails"] for row in found] == [False, False]  # exit code 1 with a result: it found something
    broken = judge("c", code="print('no memory'); raise SystemExit(3)")
    found = night.night([broken, judge("d")], 1.0, *files)
    assert [(row["ran"], row["fails"]) for row in found] == [(0, True), (4.0, False)]
    assert "ended with 3: no memory" in found[0]["verdict"]


def test_every_command_is_parsed_by_its_program():
    """Each judge's words are known to the program that they start."""
    seen = set()
    for one in night.judges():
        words = one.command(one.step, one.step, Path("out.json"))
        program = tuple(words[1 : 3 if words[1].startswith("tools") else 4])
        if program in seen:
            continue
        seen.add(program)
        options = {word for word in words if word.startswith("--")}
        helped = itertools.takewhile(lambda word: not word.startswith("--"), words)
        text = subprocess.run([*helped, "--help"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
        assert options <= set(text.replace(",", " ").replace("[", " ").split()), words
    assert len(seen) >= 6

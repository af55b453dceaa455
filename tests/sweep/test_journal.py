"""A journal keeps finished points after a kill, after Ctrl-C and with a broken line, and rejects another sweep."""

import json
import pickle
import signal
import subprocess
import sys
import time
import warnings
from dataclasses import dataclass
from functools import partial
from importlib.util import spec_from_file_location
from pathlib import Path

import pytest
import sweep_points

from palpate.base.errors import OutputError, PalpateWarning, SweepError
from palpate.base.sweep import sweep, work
from palpate.base.sweep.journal import Journal, steady
from palpate.base.sweep.work import seed_of
from palpate.scene.scene import Scene

GRID = {"K": [1.0, 2.0, 4.0], "law": ["a", "b"]}


def done(journal: Path) -> int:
    return max(0, journal.read_bytes().count(b"\n") - 1) if journal.exists() else 0


def works(pid: str) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def calls_in(folder: Path) -> int:
    return sum(len(file.read_text().split()) for file in folder.iterdir())


@pytest.fixture
def stopped(tmp_path):
    """A sweep of 200 points that was stopped by a signal: (command, folder of its calls, journal, standard error)."""

    def stop(signal_number):
        calls, journal = tmp_path / "calls", tmp_path / "journal"
        calls.mkdir()
        command = [sys.executable, sweep_points.__file__, str(calls), str(journal)]
        process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        while done(journal) < 40:
            assert process.poll() is None
            time.sleep(0.01)
        process.send_signal(signal_number)
        output = process.communicate()[1]
        deadline = time.monotonic() + 5.0
        while any(works(file.name) for file in calls.iterdir()):  # workers of a killed parent end after their point
            assert time.monotonic() < deadline
            time.sleep(0.02)
        return command, calls, journal, output

    return stop


def test_ctrl_c_keeps_finished_points_and_ends_the_workers(stopped):
    _, calls, journal, output = stopped(signal.SIGINT)
    assert output.rstrip().endswith("KeyboardInterrupt")
    assert output.count("Traceback") == 1  # the workers are silent
    assert 40 <= done(journal) <= calls_in(calls) < 200


def test_killed_sweep_resumes_from_its_journal(stopped):
    command, calls, journal, _ = stopped(signal.SIGKILL)
    kept, before = done(journal), calls_in(calls)
    assert 40 <= kept < 200
    with journal.open("ab") as torn:
        torn.write(b'0badc0de {"point":19')
    assert subprocess.run(command, timeout=60).returncode == 0
    assert calls_in(calls) - before == 200 - kept  # points in the journal are not repeated
    lines = journal.read_bytes().splitlines()[1:]
    found = {e["point"]: e["values"]["x"] for e in (json.loads(line.partition(b" ")[2]) for line in lines)}
    assert found == {k: seed_of(7, k) % 1000 + k for k in range(200)}


def test_finished_journal_is_not_recomputed(tmp_path, monkeypatch):
    first = sweep(sweep_points.draw, GRID, 1, "serial", resume=tmp_path / "j")
    size = (tmp_path / "j").stat().st_size
    monkeypatch.setattr("palpate.base.sweep.work.Work._answer", None)  # any computation would fail
    assert sweep(sweep_points.draw, GRID, 1, "serial", resume=tmp_path / "j").rows() == first.rows()
    assert (tmp_path / "j").stat().st_size == size


def test_broken_line_repeats_only_its_point(tmp_path):
    first = sweep(sweep_points.draw, GRID, 1, "serial", resume=tmp_path / "j")
    lines = (tmp_path / "j").read_bytes().splitlines(keepends=True)
    lines[3] = lines[3].replace(b'"x":', b'"x":1')
    (tmp_path / "j").write_bytes(b"".join(lines))
    with pytest.warns(PalpateWarning, match="1 broken line"):
        assert sweep(sweep_points.draw, GRID, 1, "serial", resume=tmp_path / "j").rows() == first.rows()
    with warnings.catch_warnings():
        warnings.simplefilter("error", ResourceWarning)
        assert done(tmp_path / "j") == 7


@dataclass(frozen=True)
class Held:
    given: frozenset[int]
    where: Path = Path("/a")


def test_bound_arguments_have_one_fingerprint_in_every_process():
    """The order of a set differs between processes, as its pickle does; a scene holds the set of its given keys."""
    one, other = frozenset([0, 8]), frozenset([8, 0])
    assert one == other
    assert list(one) != list(other)
    assert pickle.dumps(one) != pickle.dumps(other)  # control
    assert steady(({"a": Held(one)},)) == steady(({"a": Held(other)},))
    assert steady(Held(one)) != steady(Held(frozenset([0, 9])))
    scenes = [Scene.parse("objects: [{name: floor, plane: {size: 0.2}, stiffness: 500}]") for _ in range(2)]
    object.__setattr__(scenes[0], "__pydantic_fields_set__", {0, 8})
    object.__setattr__(scenes[1], "__pydantic_fields_set__", {8, 0})
    assert steady(scenes[0]) == steady(scenes[1])
    assert steady(scenes[0]) != steady(Scene.parse("objects: [{name: floor, plane: {size: 0.2}, stiffness: 501}]"))


def test_failed_points_are_retried(tmp_path):
    for _ in range(2):
        with pytest.raises(SweepError, match=f"the successful points are kept in {tmp_path / 'j'}"):
            sweep(sweep_points.picky, {"k": range(8)}, executor="serial", resume=tmp_path / "j")
        assert done(tmp_path / "j") == 6


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"fn": sweep_points.picky}, 'fn was "sweep_points.draw" and is "sweep_points.picky"'),
        ({"fn": partial(sweep_points.draw)}, "code was "),
        ({"seed": 2}, "seed was 1 and is 2"),
        ({"grid": {**GRID, "law": ["a", "c"]}}, "axes was "),
        ({"where": lambda p: p["K"] > 1}, "points was "),
    ],
)
def test_journal_of_another_sweep_is_rejected(change, message, tmp_path):
    same = {"fn": sweep_points.draw, "grid": GRID, "seed": 1, "executor": "serial", "resume": tmp_path / "j"}
    sweep(**same)
    with pytest.raises(SweepError, match="the journal belongs to another sweep") as refusal:
        sweep(**same | change)
    assert message in str(refusal.value)


def test_journal_of_another_version_is_rejected(tmp_path, monkeypatch):
    sweep(sweep_points.draw, GRID, 1, "serial", resume=tmp_path / "j")
    monkeypatch.setattr("palpate.base.sweep.run.identity", lambda: "9.9.9 (new)")
    with pytest.raises(SweepError, match=r"version was .* and is \"9.9.9 \(new\)\""):
        sweep(sweep_points.draw, GRID, 1, "serial", resume=tmp_path / "j")


@pytest.mark.parametrize("package", ["palpate", "palpate_lab"])
def test_identity_follows_the_sources_of_product_and_laboratory(package, tmp_path, monkeypatch):
    """A study's helpers lie in the laboratory; results of before a change must not be taken up."""
    file = tmp_path / package / "folder" / "work.py"
    file.parent.mkdir(parents=True)
    monkeypatch.setattr(work, "find_spec", lambda name: spec_from_file_location(name, tmp_path / name / "__init__.py"))
    found = []
    for text in ("A = 1\n", "A = 2\n"):
        file.write_text(text)
        found.append(work.identity.__wrapped__())
    assert found[0] != found[1]


def test_invalid_journal_files_are_rejected(tmp_path):
    (tmp_path / "notes.txt").write_text("buy milk\n")
    with pytest.raises(SweepError, match=r"notes.txt: this is not a journal of a sweep"):
        sweep(sweep_points.draw, GRID, 1, "serial", resume=tmp_path / "notes.txt")
    (tmp_path / "one.txt").write_text("buy milk")  # no complete line
    with pytest.raises(SweepError, match=r"one.txt: this is not a journal of a sweep"):
        sweep(sweep_points.draw, GRID, 1, "serial", resume=tmp_path / "one.txt")
    assert (tmp_path / "one.txt").read_text() == "buy milk"
    with pytest.raises(OutputError, match="the journal cannot be written"):
        sweep(sweep_points.draw, GRID, 1, "serial", resume="/proc/journal")
    with Journal(tmp_path / "j", {}), pytest.raises(SweepError, match="the journal is in use"):
        Journal(tmp_path / "j", {})

"""Common features of the study commands: figures, JSON, labelled results, and resumption after a stop."""

import json
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path

import pytest
import sweep_points
from rich.table import Table
from scipy.io import netcdf_file

from palpate.base.errors import JournalError, MissingExtraError, OutputError
from palpate.base.sweep import Axis
from palpate.cli._folder import entries
from palpate_lab.studies import _command as command

GRID = {"k": Axis([1, 3], "mm", "a length")}


@dataclass
class Study(command.SweepStudy):
    """A study of two points."""

    seed: int = 4
    drawn: list = field(default_factory=list)

    def study(self, console):
        rows = self.sweeper(console)(sweep_points.picky, GRID, self.seed, title="").rows()
        return command.Findings(rows, lambda folder: [folder / "a.png"], [Table("k"), "two points"])


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(command, "sweep", lambda *args, **more: command_sweep(*args, **more | {"executor": "serial"}))
    return tmp_path


command_sweep = command.sweep


def test_study_prints_draws_and_writes_its_results(folder, capsys):
    assert Study(json=folder / "s.json")() == 0
    output = capsys.readouterr().out
    assert "two points" in output
    assert "picture runs/study-test_command/a.png" in output
    assert "data runs/study-test_command/test_command.nc" in output
    assert json.loads((folder / "s.json").read_text()) == [{"k": 1, "x": 1}, {"k": 3, "x": 3}]
    with netcdf_file(folder / "runs/study-test_command/test_command.nc", mmap=False) as file:
        assert file.variables["k"].units == b"mm"
        assert file.seed == 4
    assert [f.name for f in (folder / "runs/study-test_command").iterdir()] == ["test_command.nc"]  # no journal


def test_an_interval_without_ends_is_written(folder):
    """Few units have no interval: `study guidance --operators 3 --json` ended in a traceback."""

    class Few(Study):
        def study(self, console):
            return command.Findings([{"low": float("nan"), "n": 3}], lambda folder: [], [])

    assert Few(json=folder / "s.json")() == 0
    assert json.loads((folder / "s.json").read_text()) == [{"low": None, "n": 3}]


def test_stopped_study_is_resumed(folder, capsys, monkeypatch):
    def stop(*args):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("palpate.base.sweep.run._serial", stop)
        with pytest.raises(KeyboardInterrupt):
            Study()()
    journal = folder / "runs/study-test_command/test_command.journal"
    assert f"kept in {journal.relative_to(folder)}: run the same command again to continue" in capsys.readouterr().out
    assert Study(seed=5)() == 0  # another sweep starts from the beginning
    assert not journal.exists()


def test_given_journal_is_kept_and_must_match(folder):
    assert Study(resume=folder / "j", out=folder / "o.nc")() == 0
    assert (folder / "j").exists()
    assert (folder / "o.nc").exists()
    with pytest.raises(JournalError, match="seed was 4 and is 5"):
        Study(resume=folder / "j", seed=5)()


def test_missing_packages_and_folders_are_reported_before_the_work(folder, monkeypatch):
    monkeypatch.setattr(command, "find_spec", lambda name: None)
    with pytest.raises(MissingExtraError, match=r"palpate\[report\]"):
        Study()()
    with pytest.raises(OutputError):
        Study(json=folder)()


def test_every_study_is_such_a_command_and_is_documented():
    page = (Path(__file__).resolve().parents[2] / "docs" / "studies.md").read_text()
    found = entries(["palpate_lab.studies"])
    assert len(found) >= 12
    for name, entry in found.items():
        study = import_module(entry.module).Command
        if name != "demonstrations":  # it writes a data set, no figures
            assert issubclass(study, command.Study)
            assert study().name == name
        assert f"  palpate study {name}" in study.__doc__
        assert f"| `{name}` |" in page

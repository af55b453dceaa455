"""`palpate experiment`: a dry run from start to end, its files, and what it says about mistakes."""

import csv
import json
import re

import json_contract
import pytest
from small_experiment import FILE

from palpate.base.errors import JournalError
from palpate.cli import main
from palpate.experiment import Study
from palpate.record import Record

pytest.importorskip("statsmodels", reason="statsmodels is not installed (extra experiment)")
pytest.importorskip("matplotlib", reason="matplotlib is not installed (extra report)")


@pytest.fixture
def dry_run(folder, capsys):
    """Run the command in this process; the JSON goes to the standard output."""

    def run(*more):
        code = main(["experiment", str(folder / "small.yaml"), "--out", str(folder / "data"), "--json", "-", *more])
        out, err = capsys.readouterr()
        return code, json.loads(out) if code == 0 else out, err

    return run


def test_dry_run_from_start_to_end(folder, dry_run):
    code, found, said = dry_run("--simulate", "2", "--workers", "1", "--power")
    assert code == 0
    assert found["simulated"] is True
    assert "2 simulated participants, which say nothing about people" in said
    assert set(found) == json_contract.keys("experiment")
    assert set(found["effects"][0]) == json_contract.keys_of("experiment", "`effects`")
    assert set(found["participants"][0]) == json_contract.keys_of("experiment", "`participants`")
    assert set(found["power"][0]) == json_contract.keys_of("experiment", "`power`")
    assert [one["ended"] for one in found["participants"]] == [2, 2]
    assert found["trials"] == 4
    assert sum(found["preference"].values()) == 2
    assert {one["measure"] for one in found["answers"]} == {"tlx", "trust"}

    page = (folder / "data" / "report.html").read_text()
    assert "<strong>Simulated.</strong>" in page
    assert "Force sensitivity" in page
    assert "<td>felt: False</td>" in page
    assert "<td>the scene as it is</td>" in page
    assert len(re.findall(r"https?://", page.replace("http://www.w3.org", ""))) == 0

    table = (folder / "data" / "trials.csv").read_text()
    rows = list(csv.DictReader(table.splitlines()))
    assert len(rows) == 4
    assert "S01" not in table
    assert {row["participant"] for row in rows} == {"A001", "A002"}

    manifest = json.loads((folder / "data" / "manifest.json").read_text())
    assert {"seed", "palpate", "sha256", "scenes", "plan"} <= set(manifest)
    records = sorted((folder / "data").glob("S0*/trial-*/*/record.mcap"))
    assert len(records) == 4
    assert all(Record.open(path).complete for path in records)

    code, again, _ = dry_run("--simulate", "2", "--workers", "1")
    assert again["effects"] == found["effects"], "it continues where it ended: nothing is run again"
    assert sorted((folder / "data").glob("S0*/trial-*/*/record.mcap")) == records


def test_the_file_alone_is_checked_and_nothing_is_written(folder, dry_run):
    code, found, said = dry_run()
    assert code == 0
    assert "0 of 8 trials ended" in said
    assert found["report"] is None
    assert not (folder / "data").exists()


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (("--simulate", "0"), "--simulate 0: must be"),
        (("--simulate", "2000"), "2000: must be from 1 to 1000"),
        (("--simulate", "1", "--power"), "--power needs the spread between participants"),
    ],
)
def test_contradictions_are_refused(dry_run, more, words):
    code, _, said = dry_run(*more)
    assert code == 2
    assert words in said


def test_a_changed_file_is_told_by_the_command(folder, small, dry_run):
    Study(small, folder / "data")
    (folder / "small.yaml").write_text(FILE.replace("seed: 3", "seed: 4"))
    code, _, said = dry_run()
    assert code == 2
    assert "seed was 3 and is 4" in said


def test_a_wrong_pseudonym_freezes_nothing(folder, dry_run):
    pytest.importorskip("viser", reason="viser is not installed (extra viewer)")
    code, _, said = dry_run("--participant", "P09")
    assert code == 2
    assert "there is no participant 'P09'" in said
    assert not (folder / "data").exists()


def test_a_single_condition_has_no_power_and_no_comparison(folder, dry_run):
    (folder / "small.yaml").write_text(FILE.replace("  force: {}\n", ""))
    code, _, said = dry_run("--power")
    assert code == 2
    assert "--power compares conditions, and there is one" in said
    code, found, _ = dry_run("--simulate", "1")
    assert code == 0
    assert found["effects"] == []
    assert (folder / "data" / "report.html").exists()


def test_codes_of_others_are_refused(small, folder):
    study = Study(small, folder / "data")
    codes = study.codes()
    assert sorted(codes.values()) == ["A001", "A002", "A003", "A004"]
    assert study.codes() == codes
    (folder / "data" / "codes.json").write_text('{"P01": "A001"}')
    with pytest.raises(JournalError, match=r"codes\.json is not that of these participants"):
        study.codes()


def test_a_missing_mixed_model_is_told_before_the_first_trial(folder, dry_run, monkeypatch):
    import importlib.util as util

    real = util.find_spec
    monkeypatch.setattr(util, "find_spec", lambda name, *more: None if name == "statsmodels" else real(name, *more))
    for options in (("--simulate", "2"), ("--participant", "P01"), ("--power",)):
        code, _, said = dry_run(*options)
        assert code == 2
        assert "palpate[experiment]" in said
    assert not (folder / "data").exists()

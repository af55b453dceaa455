"""Short runs of the cases of `palpate fuzz`, and its runner, which survives crashes."""

import pytest

from palpate.base.errors import OutputError
from palpate_lab.verify import fuzz
from palpate_lab.verify.fuzz import campaign, contact, files


@pytest.mark.parametrize("first", range(0, 400, 50))
def test_random_soups_and_paths(first):
    for seed in range(first, first + 50):
        contact.case(seed)


@pytest.mark.parametrize("first", range(0, 300, 50))
def test_damaged_files(first):
    for seed in range(first, first + 50):
        files.case(seed)


def test_crash_and_exception_are_faults_and_the_other_cases_run():
    outcome = fuzz.run("fuzz_cases", 8)
    assert outcome.runs == 8
    assert [f["seed"] for f in outcome.faults] == [3, 5, 6]
    assert outcome.faults[0]["what"] == "the process died with exit code 7"
    assert outcome.faults[1]["what"] == "a violated requirement"
    assert outcome.faults[2]["what"] == "ZeroDivisionError: integer division or modulo by zero"
    assert outcome.counts == {"fine": 5}


def test_a_case_is_endless_if_it_is_late_twice(monkeypatch):
    """Seed 20 is always late, and seed 21 once, as on a machine that is busy for a moment."""
    was_late = set()

    def campaign(outcome, first, end, on_progress):
        for seed in range(first, end):
            if seed == 20 or (seed == 21 and seed not in was_late):
                was_late.add(seed)
                return True
            outcome.runs = seed + 1 - outcome.seed
        return False

    monkeypatch.setattr(fuzz, "_campaign", campaign)
    outcome = fuzz.run("fuzz_cases", 4, 19)
    assert [(fault["seed"], fault["what"][:7]) for fault in outcome.faults] == [(20, "endless")]
    assert (outcome.runs, was_late) == (4, {20, 21})


def test_blocks_on_several_processes_give_the_outcome_of_one(monkeypatch, tmp_path):
    monkeypatch.setattr(campaign, "_LEAST", 3)
    journal = tmp_path / "journal"
    one = fuzz.run("fuzz_cases", 8)
    for workers in (1, 2):
        several = campaign.run_on_cores("fuzz_cases", 8, workers=workers, journal=journal if workers == 2 else None)
        assert (several.runs, several.faults, several.counts) == (one.runs, one.faults, one.counts)
    lines = journal.read_text().splitlines()
    journal.write_text("\n".join(lines[:-1]) + "\n" + lines[-1][:5])  # killed while it wrote
    monkeypatch.setattr(campaign, "run", lambda target, runs, seed, *rest: fuzz.run(target, runs, seed))
    again = campaign.run_on_cores("fuzz_cases", 8, journal=journal)
    assert (again.runs, again.faults, again.counts) == (one.runs, one.faults, one.counts)
    with pytest.raises(OutputError, match="another campaign"):
        campaign.run_on_cores("fuzz_cases", 9, journal=journal)


def test_no_block_counts_after_the_last_allowed_fault(monkeypatch):
    monkeypatch.setattr(campaign, "_LEAST", 2)
    outcome = campaign.run_on_cores("fuzz_cases", 8, most=2, workers=2)
    assert [fault["seed"] for fault in outcome.faults] == [3, 5]

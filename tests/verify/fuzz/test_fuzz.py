"""Short runs of the cases of `palpate fuzz`, and its runner, which survives crashes."""

import pytest

from palpate.verify import fuzz
from palpate.verify.fuzz import contact, files


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

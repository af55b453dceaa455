"""The coverage harness: each printed interval has an estimate in it, and wrong figures are seen."""

import json
import re
from pathlib import Path

import json_contract
import numpy as np
import pytest
from effort import LONG

from palpate.world.registration import organ_motion
from palpate_lab.verify.coverage import run
from palpate_lab.verify.coverage.bound import most_powerful
from palpate_lab.verify.coverage.trial import RIGHT

#: Commands that print intervals or covariances and have no file in `estimates`, with the reason.
WITHOUT = {
    "coverage": "prints the intervals of its own counts, Clopper and Pearson's",
    "check": "its deviations are those of a mesh from its smoothed copy, without an interval",
    "device wrist": "prints the smallest and largest value in the parts of a recording, which it calls so: no level",
    "experiment": "its intervals are those of the studies (palpate/base/arrays/intervals.py), which are judged there",
    "path": "its deviations are distances of two given curves, computed exactly",
}
_SAME = "of the same fit as the covariance that is judged"
_PLACE = "a position"
#: Keys of intervals in the JSON of each command, with the estimate that judges them, or the reason why none does.
JUDGED = {
    "calibrate gravity": {"coverage_95": "gravity", "std_Nm": "gravity", "std_factor_95": "gravity"},
    "calibrate dynamics": {"terms_95": "dynamics"},
    "calibrate hand": {
        "mass_kg_95": "hand", "damping_N_s_per_m_95": "hand", "stiffness_N_per_m_95": "hand",
        "lag_s_95": "a property of the load cell, of the same fit", "p_misfit": "hand",
    },
    "identify tissue": {"young_Pa_95": "tissue", "instantaneous_Pa_95": _SAME, "stiffening_95": _SAME},
    "frames": {"covariance": "frames", "p_holm": "frames"},
    "device bench": {
        "deviations": "bench", "deviation": "gain", "interval_p99_us": "a quantile of times, without an interval",
    },
    "register points": {"covariance": "points", "tre_95": "points", "size_deviation": "points"},
    "register surface": {"covariance": "surface"},
    "register handeye": {"covariance": "handeye", "board_covariance": _SAME, "size_deviation": "handeye"},
    "register camera": {"covariance": "camera", "p_TQ": _PLACE, "p_TQ_covariance": _SAME},
    "register pivot": {"covariance": "pivot", "p_TQ": _PLACE, "p_WQ": _PLACE, "pivot_covariance": _SAME},
    "register session": {"covariance": "session"},
    "study guidance": {
        **dict.fromkeys(("change_low", "change_high", "hedges_g_low", "hedges_g_high", "p_holm"), "operators"),
        **{f"{key}_more_{end}": "operators" for key in ("path_error_mm", "mean_force_N", "peak_force_N", "time_s")
           for end in ("low", "high")},
    },
    "study planning": {"entry_reduction_95": "routes", "p_holm": "routes"},
    "study force": {"deviation_kg": "payload", "interval_kg": "payload"},
}  # fmt: skip
ROOT = Path(__file__).resolve().parents[2]
#: Files that print a number after +-, with the command whose estimate judges it, or the reason why none does.
PLUS_MINUS = {
    "lab/palpate_lab/studies/wall/words.py": "half of the swing of a limit cycle, simulated exactly",
    "palpate/arm/identify/hand.py": "calibrate hand",
    "palpate/cli/commands/calibrate/gravity.py": "calibrate gravity",
    "palpate/cli/commands/calibrate/hand.py": "calibrate hand",
    "palpate/cli/commands/device/bench.py": "device bench",
    "palpate/cli/commands/register/handeye.py": "register handeye",
    "palpate/devices/accuracy.py": "device bench",
    "palpate/report/device.py": "device bench",
    "palpate/world/registration/fiducials.py": "register points",
    "palpate/world/registration/hand_eye.py": "register handeye",
}
_PLUS_MINUS = re.compile(r"(?<!\+)\+- ?\{")
_INTERVAL = re.compile(r"_95$|^covariance$|_covariance$|interval|_low$|_high$|deviation|^std|_std|^p_|^uncertain$")
_TRIALS = {"bench": 2, "dynamics": 5, "gain": 1, "payload": 2, "session": 1, "surface": 1, "tissue": 5}
if LONG:
    _TRIALS |= {"dynamics": 10, "surface": 4, "tissue": 10}


def interval_keys(pages):
    """Keys of intervals, deviations, covariances and probabilities on the pages of the JSON, by command."""
    sections = [section for page in pages for section in page.read_text(encoding="utf-8").split("\n## ")[1:]]
    found = {
        re.match(r"`palpate ([^`]*)`", one)[1]: {key for key in re.findall(r"`(\w+)`", one) if _INTERVAL.search(key)}
        for one in sections
        if one.startswith("`palpate ")
    }
    return {command: keys for command, keys in found.items() if keys}


def without_estimate(found):
    """Keys that no estimate judges and no reason excuses, by command."""
    bad = {command: keys - set(JUDGED.get(command, {})) for command, keys in found.items() if command not in WITHOUT}
    return {command: keys for command, keys in bad.items() if keys}


def test_every_key_of_an_interval_has_an_estimate():
    found = interval_keys(json_contract.PAGES)
    assert without_estimate(found) == {}
    assert {command: set(keys) for command, keys in JUDGED.items()} == {
        command: keys for command, keys in found.items() if command not in WITHOUT
    }
    for command, keys in JUDGED.items():
        assert {run.estimate(name).COMMAND for name in keys.values() if name in run.names()} <= {command}
    assert set(run.names()) <= {name for keys in JUDGED.values() for name in keys.values()}


def test_a_new_command_and_a_new_key_without_an_estimate_are_found(tmp_path):
    """A judged command hid a key of its own that nothing judged: the gain of `device bench`."""
    (tmp_path / "new.md").write_text(
        "# Keys\n\n## `palpate guess`\n\n| `young_Pa_95` | low and high |\n\n"
        "## `palpate device bench`\n\n| `deviations`, `gain_95` | |\n\n## `palpate check`\n\n| `std_mm` | |\n"
    )
    assert without_estimate(interval_keys([tmp_path / "new.md"])) == {
        "guess": {"young_Pa_95"}, "device bench": {"gain_95"},
    }  # fmt: skip


def printing_plus_minus(folder):
    files = (one for part in ("palpate", "lab") for one in (folder / part).rglob("*.py"))
    return {str(one.relative_to(folder)) for one in files if _PLUS_MINUS.search(one.read_text(encoding="utf-8"))}


def test_every_number_printed_after_plus_minus_belongs_to_an_estimate():
    assert printing_plus_minus(ROOT) == set(PLUS_MINUS)
    judged = {run.estimate(name).COMMAND for name in run.names()}
    assert {name for name, of in PLUS_MINUS.items() if of not in judged} == {"lab/palpate_lab/studies/wall/words.py"}


def test_a_new_number_after_plus_minus_is_found(tmp_path):
    (tmp_path / "palpate").mkdir()
    (tmp_path / "palpate" / "new.py").write_text('print(f"{value:.3g} +-{reach:.1g}")\n')
    (tmp_path / "palpate" / "other.py").write_text('print(f"{value:.3g}")\n')
    assert printing_plus_minus(tmp_path) == {"palpate/new.py"}


def lacking_rows(rows):
    """Forms of estimates that the kept table lacks, and rows of forms that no longer exist."""
    kept = {(row["estimate"], row["form"], row["description"]) for row in rows}
    forms = {(name, *form) for name in run.names() for form in run.estimate(name).FORMS.items()}
    return forms ^ kept


def test_every_form_of_every_estimate_has_its_row_in_the_kept_table():
    rows = json.loads((ROOT / "docs" / "results" / "coverage.json").read_text(encoding="utf-8"))["result"]["rows"]
    assert lacking_rows(rows) == set()
    gone = {(row["estimate"], row["form"], row["description"]) for row in rows if row["estimate"] == "gain"}
    assert lacking_rows([row for row in rows if row["estimate"] != "gain"]) == gone != set()


@pytest.mark.parametrize("name", run.names())
def test_a_few_trials_of_each_estimate(name):
    """The asked share of the right form lies in the interval of what was found; each wrong form runs."""
    one = run.estimate(name)
    assert next(iter(one.FORMS)) == RIGHT
    assert len(one.FORMS) >= 4
    rows = run.run([name], _TRIALS.get(name, 10), seed=3, workers=0)
    right = rows[0]
    assert right.cover_95[0] <= 0.97
    assert right.cover_95[1] >= 0.93
    assert right.told <= 0.3
    assert [row.form for row in rows] == list(one.FORMS)


def test_bound_of_what_can_be_told_is_that_of_known_directions_and_above_the_chi_square_test():
    """One direction seen: the one-sided normal test, averaged over random directions. All seen: above chi-square."""
    from scipy.special import chdtri, chndtr, ndtr

    seen = np.abs(np.linspace(-1.0, 1.0, 20_001))  # the component of a random direction is uniform
    two_sided = np.mean(ndtr(3.0 * seen - 1.96) + ndtr(-3.0 * seen - 1.96))
    assert most_powerful(np.diag([9.0, 0.0, 0.0]), 1.0, 0.05) == pytest.approx(two_sided, abs=0.02)
    chi_square = 1.0 - chndtr(chdtri(3, 0.02), 3, 9.0)
    assert most_powerful(9.0 * np.eye(3), 1.0, 0.02) == pytest.approx(chi_square, abs=0.02)
    M = np.diag([16.0, 4.0, 1.0])
    d = organ_motion.directions()
    assert most_powerful(M, 1.0, 0.02) >= np.mean(1.0 - chndtr(chdtri(3, 0.02), 3, (d**2) @ np.diag(M))) - 0.01


def test_row_of_a_narrow_interval_and_of_a_silent_bias_is_not_met():
    """Normal errors with a stated deviation of half the true one, and errors with a bias of three deviations."""
    rng = np.random.default_rng(0)

    def row(form, bias, size, told):
        z = size * rng.normal(size=400) + bias
        return run._row(
            "x", "x", form, "", (np.abs(z) < 1.96).astype(float), z**2, np.full(400, told), np.full(400, np.nan)
        )

    assert row(RIGHT, 0.0, 1.0, 0.0).met
    assert not row(RIGHT, 0.0, 2.0, 0.0).met
    assert not row(RIGHT, 0.0, 0.3, 0.0).met
    assert not row("wrong", 3.0, 1.0, 0.0).met
    assert row("wrong", 3.0, 1.0, 1.0).met
    assert row("wrong", 3.0, 1.0, 0.0).bias == pytest.approx(3.0, rel=0.1)
    assert row("wrong", 0.3, 1.0, 0.0).met

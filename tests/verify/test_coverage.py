"""The coverage harness: each printed interval has an estimate in it, and wrong figures are seen."""

import re
from pathlib import Path

import json_contract
import numpy as np
import pytest
from effort import LONG

from palpate_lab.verify.coverage import run
from palpate_lab.verify.coverage.trial import RIGHT

#: Commands that print intervals or covariances and have no file in `estimates`, with the reason.
WITHOUT = {
    "check": "its deviations are those of a mesh from its smoothed copy, without an interval",
    "device wrist": "prints the smallest and largest value in the parts of a recording, which it calls so: no level",
    "experiment": "its intervals are those of the studies (palpate/base/arrays/intervals.py), which are judged there",
    "path": "its deviations are distances of two given curves, computed exactly",
}
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
_TRIALS = {"bench": 2, "dynamics": 5, "gain": 2, "payload": 2, "session": 1, "surface": 1, "tissue": 5}
if LONG:
    _TRIALS |= {"dynamics": 10, "surface": 4, "tissue": 10}


def commands_with_intervals() -> set[str]:
    sections = [section for page in json_contract.PAGES for section in page.read_text().split("\n## ")[1:]]
    return {
        re.match(r"`palpate ([^`]*)`", section)[1]
        for section in sections
        if section.startswith("`palpate ") and any(_INTERVAL.search(k) for k in re.findall(r"`(\w+)`", section))
    }


def test_every_command_that_prints_an_interval_has_an_estimate():
    judged = {run.estimate(name).COMMAND for name in run.names()}
    found = commands_with_intervals()
    assert {"register points", "calibrate hand", "identify tissue", "device bench"} <= found
    assert found - judged - set(WITHOUT) - {"coverage"} == set()
    assert not judged & set(WITHOUT)


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


def test_row_of_a_narrow_interval_and_of_a_silent_bias_is_not_met():
    """Normal errors with a stated deviation of half the true one, and errors with a bias of three deviations."""
    rng = np.random.default_rng(0)

    def row(form, bias, size, told):
        z = size * rng.normal(size=400) + bias
        return run._row("x", "x", form, "", (np.abs(z) < 1.96).astype(float), z**2, np.full(400, told))

    assert row(RIGHT, 0.0, 1.0, 0.0).met
    assert not row(RIGHT, 0.0, 2.0, 0.0).met
    assert not row(RIGHT, 0.0, 0.3, 0.0).met
    assert not row("wrong", 3.0, 1.0, 0.0).met
    assert row("wrong", 3.0, 1.0, 1.0).met
    assert row("wrong", 3.0, 1.0, 0.0).bias == pytest.approx(3.0, rel=0.1)
    assert row("wrong", 0.3, 1.0, 0.0).met

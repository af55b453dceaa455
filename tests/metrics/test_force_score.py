"""The score of force sensitivity tells careless from careful simulated hands, and not fast from slow ones."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from palpate import Scene, Session, metrics

SCENES = Path(__file__).resolve().parents[2] / "scenes"
CAREFUL = {"force": 0.8, "tremor": 1e-4, "pace": 1.0}
CARELESS = {"force": 2.0, "tremor": 4e-4, "pace": 1.0}


def score(scene, tmp_path, force, tremor, pace):
    """The score of a hand on a shipped scene: its intended force [N], tremor [m] and pace (1: the careful one's)."""
    made = Scene.load(SCENES / f"{scene}.yaml").model_dump(exclude_unset=True)
    made.setdefault("operator", {}).setdefault("palpate", {})
    phases = {"approach": 0.8, "press": 0.6, "slide": 2.0, "leave": 0.8}
    made["operator"]["palpate"] |= {"force": force} | {name: t / pace for name, t in phases.items()}
    made["operator"]["tremor"] = tremor
    made["record"] = {"report": False}
    summary = Session(Scene.model_validate(made), out=str(tmp_path)).run(sum(phases.values()) / pace)
    return metrics.summary(summary.record)["force_sensitivity"]


@pytest.mark.parametrize("scene", ["palpation", "nodule", "solids"])
def test_care_counts_and_pace_does_not(scene, tmp_path):
    careful = score(scene, tmp_path, **CAREFUL)
    assert score(scene, tmp_path, **CARELESS) < careful - 15.0
    assert score(scene, tmp_path, **CAREFUL | {"pace": 2.0}) == pytest.approx(careful, abs=5.0)


@given(force=st.lists(st.floats(0.06, 10.0), min_size=20, max_size=60), times=st.integers(2, 5))
def test_a_task_repeated_has_the_same_score(force, times):
    once, again = (metrics.force_sensitivity(np.repeat(np.sort(force), n)) for n in (10, 10 * times))
    assert once.excess == pytest.approx(again.excess)
    assert once.score == pytest.approx(again.score, abs=4.0)


def test_each_demerit_is_zero_for_a_careful_hand_and_sees_its_fault():
    steady = np.full(1000, 0.9)
    assert metrics.force_sensitivity(steady).score == 100.0
    assert metrics.force_sensitivity(2.0 * steady).excess == pytest.approx(0.8)
    blow = steady.copy()
    blow[:20] = 6.0
    assert metrics.force_sensitivity(blow).peaks == pytest.approx(1.0)
    wavy = 0.5 + 0.4 * np.sin(np.linspace(0, 40 * np.pi, 1000))
    assert metrics.force_sensitivity(wavy).unsteady > 0.1
    assert np.isnan(metrics.force_sensitivity(np.zeros(10)).score)
    with pytest.raises(ValueError, match="harm = -1"):
        metrics.force_sensitivity(steady, harm=-1.0)

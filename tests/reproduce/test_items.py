"""Verdicts of the items that take seconds, and that a planted fault changes them."""

from functools import partial

import numpy as np
import pytest
from paper_items import AGREE, JUDGED, LONG

from palpate import _core
from palpate.arm import Arm
from palpate_lab.reproduce import checks
from palpate_lab.reproduce.catalogue import items
from palpate_lab.reproduce.items import dynamics, wall


@pytest.mark.parametrize("name", AGREE)
def test_the_papers_claim_holds(name, work):
    outcome = items()[name].make(work)
    assert outcome.verdict == "agrees", outcome.why
    assert outcome.value
    assert outcome.data
    assert outcome.drawings


def test_every_item_is_made_by_a_test():
    assert {*JUDGED, *LONG} == {*items()}


def test_the_printed_sign_of_eq_12_does_not_hold(work):
    outcome = items()["eq12"].make(work)
    assert outcome.verdict == "differs"
    assert max(outcome.value["residuals"].values()) < 1e-8
    assert outcome.value["residual_with_the_printed_sign_Nm"] > 1.0


def test_a_heavier_model_differs(work, monkeypatch):
    heavier = Arm.mtm("right")
    other = heavier.with_scaled_masses(np.full(7, 1.001))
    monkeypatch.setattr(dynamics.Arm, "mtm", lambda side: heavier)
    monkeypatch.setattr(heavier, "mass_matrix", other.mass_matrix)
    outcome = items()["eq1"].make(work)
    assert outcome.verdict == "differs"
    assert "M(q) by" in outcome.why


def test_a_softer_spring_differs(work, monkeypatch):
    true = _core.force

    def softer(K, *rest):
        return true(0.9995 * K, *rest)

    monkeypatch.setattr(_core, "force", softer)
    assert items()["eq6"].make(work).verdict == "differs"
    assert items()["eq8"].make(work).verdict == "agrees"  # within its 0.1 %
    monkeypatch.setattr(_core, "force", partial(true, stiffness_scale=0.99))
    assert items()["eq8"].make(work).verdict == "differs"


@pytest.mark.parametrize("residual", [1e-3, np.nan, np.inf])
def test_a_check_that_fails_overrules_the_given_verdict(residual):
    bad = checks.Check("one thing", "another way", np.array([0.0, residual]), 1e-6, "N")
    outcome = checks.outcome([bad], "printed", "reason", verdict="agrees")
    assert outcome.verdict == "differs"
    assert "one thing" in outcome.why


def test_table_1_has_every_row_beside_the_published_one(work, monkeypatch):
    monkeypatch.setattr(wall, "_TRIED", 6)
    monkeypatch.setattr(wall, "_REFINED", 1)
    monkeypatch.setattr(wall, "_STEPS", 2)
    monkeypatch.setattr(wall, "together", partial(wall.together.__wrapped__, count=6))
    outcome = items()["table1"].make(work)
    assert outcome.verdict == "differs"
    assert [row["overshoot_published"] for row in outcome.data] == [10.2, 1.27, 1.25]
    assert [row["steady_state_read_mm"] for row in outcome.data] == [10.0, 1.5, 2.0]
    assert outcome.value["tried"] == 9
    low, high = np.array(list(outcome.value["ranges"].values())).T
    best = np.array(list(outcome.value["best_hand_for_all_rows"].values()))
    assert ((best >= 0.999 * low) & (best <= 1.001 * high)).all()


def test_the_error_of_a_hand_is_that_of_its_worst_row():
    assert wall.error(np.array([10.2, 1.27, 1.25])) == pytest.approx(0.0)
    assert wall.error(np.array([10.2, 1.27, 2.5])) == pytest.approx(1.0)
    assert wall.error(np.array([5.1, 1.27, 1.25])) == pytest.approx(1.0)
    assert wall.error(np.array([10.2, 1.27, 1.25]), rests=False) == pytest.approx(1.0)  # rows 2 and 3 must rest
    assert wall.error(np.array([5.1, np.nan, np.nan])) == np.inf

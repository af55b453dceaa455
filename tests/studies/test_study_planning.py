"""`palpate study planning`, in small: one route, two operators."""

from pathlib import Path

import json_contract
import numpy as np
import pytest

pytest.importorskip("ompl", reason="motion planning needs the extra planning")
pytest.importorskip("coal", reason="motion planning needs the extra planning")
pytest.importorskip("ruckig", reason="motion planning needs the extra planning")

from palpate.simulators.operators.trial import Trial
from palpate_lab.studies.planning import work
from palpate_lab.studies.planning.figures import draw
from palpate_lab.studies.planning.routes import MARGIN, Route, route_between

START, TARGET = (0.000758, -0.045161, 0.034410), (-0.067382, -0.080744, -0.013648)  # 3.3 mm from the liver


@pytest.fixture(scope="module")
def route() -> Route:
    found = route_between(np.array(START), np.array(TARGET), work.SEED)
    assert found is not None
    return found


def test_operators_led_along_a_plan_stay_nearer_to_it(route: Route, tmp_path: Path) -> None:
    rows = work.measured([route], 2)
    found = work.summary(rows)
    assert found["follow"]["path_error_mm"] < 0.7 * found["none"]["path_error_mm"]
    assert found["follow"]["entry_mm_s"] <= found["none"]["entry_mm_s"]
    assert all(row["done"] == 1.0 for row in rows)
    assert {"seed", "conditions", "trials"} == json_contract.keys("study planning")
    measures = json_contract.keys_of("study planning", "Measures:")
    assert set(rows[0]) == {"route", "condition", "operator"} | measures
    more = json_contract.keys_of("study planning", "Conditions also have:")
    assert set(found["none"]) == measures | more
    assisted = json_contract.keys_of("study planning", "Conditions with assistance also have:")
    assert set(found["follow"]) == measures | more | assisted
    (picture,) = draw(tmp_path, rows, found)
    assert picture.stat().st_size > 10_000


def test_a_stiffer_spring_leads_more(route: Route, tmp_path: Path) -> None:
    rows = work.measured([route], 1, conditions=("none", "200", "1000"))
    found = work.summary(rows)
    assert found["1000"]["path_error_mm"] < found["200"]["path_error_mm"] < found["none"]["path_error_mm"]
    assert [file.name for file in draw(tmp_path, rows, found)] == ["study_planning_stiffness.png"]


def test_an_instrument_in_the_margin_is_judged_so(route: Route) -> None:
    at_start = work.attempt(route, 0, "none", 1)
    near = next(one for one in route.problem.world.obstacles if one.name == "liver")
    q = at_start.q[:1].repeat(20, axis=0)
    still = Trial(np.arange(20) * 0.004, at_start.p_WT[:1].repeat(20, axis=0), np.zeros(20), np.zeros(20), True, q)
    assert work.judged(route, still)["entry_mm_s"] == 0.0
    from palpate.planning.checker import Checker

    checker = Checker(route.problem.robot, route.problem.world)
    (closest, *_) = checker.nearest(q[0, :6], 0.2)
    X = near.X_WO.copy()  # the liver is moved until it is 2 mm from the instrument, or nearer
    liver = next(one for one in checker.nearest(q[0, :6], 0.2) if one.pair[1] == "liver")
    X[:3, 3] += (liver.p_robot_W - liver.p_world_W) * (1.0 - 0.002 / liver.distance)
    moved = route.problem.with_world(route.problem.world.moved("liver", X))
    judged = work.judged(Route(route.rig, moved, route.plan, route.path, route.fixtures), still)
    assert judged["deepest_mm"] >= 1e3 * (MARGIN - 0.002) - 1e-3
    assert judged["entry_mm_s"] == pytest.approx(judged["deepest_mm"] * judged["inside_s"], rel=1e-6)
    assert closest.distance >= MARGIN

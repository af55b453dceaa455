"""Pedals of one console from many sources, and its switches, in a session."""

import itertools

import numpy as np
import pytest

import palpate
from palpate.base.errors import StateError
from palpate.session.console import PEDALS, Console


class Hand:
    def __init__(self):
        self.values, self.requests = {}, []

    def change(self, **values):
        self.values |= values

    def request(self, request):
        self.requests.append(request)


@pytest.fixture
def hand():
    return Hand()


def test_a_pedal_is_down_while_any_source_holds_it(hand):
    console = Console([hand])
    for a, b in itertools.product((False, True), repeat=2):
        console.set("clutch", a, "foot")
        console.set("clutch", b, "viewer")
        assert console.pedals["clutch"] == (a or b)
        assert hand.values.get("clutch", False) == (a or b)


def test_presence_needs_every_source_that_reports_it(hand):
    console = Console([hand])
    assert console.present, "nobody reports presence: a simulation"
    for operator, head in itertools.product((False, True), repeat=2):
        console.set("operator", operator, "dvrk")
        console.set("head", head, "dvrk")
        assert console.present == (operator and head)
        assert hand.values.get("operator_present", True) == (operator and head)


def test_a_lost_source_fails_to_the_safe_side(hand):
    console = Console([hand])
    console.press("clutch", "foot")
    console.press("operator", "foot")
    assert console.present
    console.lose("foot")
    assert console.pedals["clutch"], "a tool must not start because a cable was pulled"
    assert not console.present
    console.press("clutch")
    console.release("clutch")
    assert not console.pedals["clutch"]


def test_changes_are_told_once_and_all_hands_get_them():
    hands, told = [Hand(), Hand()], []
    console = Console(hands)
    console.on_change(lambda name, down: told.append((name, down)))
    for down in (True, True, False, False):
        console.set("camera", down)
    console.press("coag")
    assert told == [("camera", True), ("camera", False), ("coag", True)]
    assert hands[0].values == hands[1].values
    assert hands[0].values["camera"] is False


def test_unknown_pedals_and_wrong_scales_are_refused_and_change_nothing(hand):
    console = Console([hand])
    with pytest.raises(StateError, match="foot: there is no pedal 'cluch'\n  mend: did you mean 'clutch'"):
        console.press("cluch", "foot")
    with pytest.raises(StateError, match="pedals: clutch"):
        console.press("xyz")
    for wrong in (0.0, -1.0, 11.0, float("nan"), float("inf")):
        with pytest.raises(StateError, match="scale"):
            console.set_scale(wrong)
    with pytest.raises(StateError, match="one hand"):
        console.swap()
    with pytest.raises(StateError, match="cannot be exchanged"):
        Console([hand, hand]).swap()
    assert hand.values == {}
    done = []
    Console([hand, hand], lambda: done.append(1)).swap()
    assert done == [1]


SCENE = """
objects:
  - {name: floor, plane: {}, stiffness: 400, damping: 2}
operator:
  path:
    - {t: 0, xyz: [0, 0, 0.01]}
    - {t: 4, xyz: [0.03, 0, 0.01]}
"""


@pytest.fixture
def session():
    session = palpate.Session(palpate.Scene.parse(SCENE))
    session.step(300)
    return session


def moved(session, ticks=200):
    """Motion of the tool goal over some ticks (3,) [m] and its largest step [m]."""
    p = [session.latest()["p_WT_goal"]]
    for _ in range(ticks):
        p.append(session.step().tick["p_WT_goal"])
    return p[-1] - p[0], float(np.linalg.norm(np.diff(p, axis=0), axis=1).max())


def test_each_pedal_changes_the_state_of_its_session(session):
    states = {"clutch": "clutched", "camera": "camera", "coag": "following", "operator": "homed", "head": "homed"}
    assert set(states) == set(PEDALS)
    for pedal, state in states.items():
        session.console.set(pedal, pedal not in ("operator", "head"))
        session.step(2)
        assert session.state.session == state, pedal
        session.console.set(pedal, pedal in ("operator", "head"))
        session.step(2)
        assert session.state.session == "following"


def test_locks_and_scale_act_live_without_a_jump(session):
    session.step(1200)
    free, _ = moved(session)
    assert np.linalg.norm(free) > 1e-3
    session.console.lock_translation()
    session.step()
    locked, step = moved(session)
    assert not locked.any()
    assert step == 0.0
    session.console.lock_translation(False)
    session.console.set_scale(0.1)
    hand = 0.35e-3  # [m] in a tick: the simulated hand returns to its path at 0.25 m/s
    assert moved(session)[1] < 0.1 * hand
    session.console.set_scale(None)
    _, step = moved(session, 600)
    assert step < 0.5 * hand


def test_while_translation_is_locked_the_hand_feels_nothing():
    session = palpate.Session(
        palpate.Scene.parse(SCENE.replace("0.03, 0, 0.01", "0, 0, -0.004").replace("t: 4", "t: 0.4"))
    )
    session.step(800)
    assert session.state.force > 0.3
    session.console.lock_translation()
    session.step(300)
    assert session.state.session == "following"
    assert session.state.force == 0.0
    session.console.lock_translation(False)
    session.step(600)
    assert session.state.force > 0.1


def test_a_tool_is_exchanged_while_all_holds(session):
    session.console.begin_tool_exchange()
    session.step(3)
    assert session.state.session == "hold"
    with pytest.raises(StateError, match="the session is hold"):
        session.console.begin_tool_exchange()
    session.console.end_tool_exchange()
    session.step(3)
    assert session.state.session == "following"

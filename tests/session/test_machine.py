"""The state machine of a session: its table, requests and refusals, and that no transition makes a step."""

import functools
import importlib.util
import itertools
from pathlib import Path

import numpy as np
import pytest

import palpate
from palpate import _core
from palpate.base.errors import StateError
from palpate.record.ticks import STATUS
from palpate.session import machine
from palpate.session.faults import HOW_TO_LEAVE, NO_FAULTS, how_to_leave

LEVELS = (
    "power", "home", "at_home", "follow", "aligned", "clutch", "camera", "hold", "fault", "recover", "settled",
    "execute", "moving",
)  # fmt: skip
HOLDS = {
    "power_on": lambda x: x["power"], "power_off": lambda x: not x["power"], "home": lambda x: x["home"],
    "follow": lambda x: x["follow"], "stop": lambda x: not x["follow"], "clutch": lambda x: x["clutch"],
    "unclutch": lambda x: not x["clutch"], "camera": lambda x: x["camera"], "uncamera": lambda x: not x["camera"],
    "hold": lambda x: x["hold"], "resume": lambda x: not x["hold"], "at_home": lambda x: x["at_home"],
    "recover": lambda x: x["recover"] and not x["fault"], "not_home": lambda x: not x["at_home"],
    "aligned": lambda x: x["aligned"], "fault": lambda x: x["fault"], "settled": lambda x: x["settled"],
    "execute": lambda x: x["execute"], "ended": lambda x: not (x["execute"] or x["moving"]),
}  # fmt: skip  # written here again: the second opinion on what the machine reads from its levels


def walk(state, levels, table=machine.TRANSITIONS):
    """All transitions that the levels allow, by the published table."""
    rows = _rows(table)
    for _ in machine.NAMES:
        after = next((to for cause, to in rows[state] if HOLDS[cause](levels)), state)
        if after == state:
            return state
        state = after
    raise AssertionError(f"the levels {levels} never come to rest")


@functools.cache
def _rows(table):
    return {name: [(cause, to) for at, cause, to in table if at == name] for name in machine.NAMES}


def levels_of(bits):
    return dict(zip(LEVELS, bits, strict=True))


def given(levels):
    now = _core.SessionInput()
    for name, value in levels.items():
        setattr(now, name, bool(value))
    return now


@functools.cache
def _inputs():
    """All combinations of levels, with the machine's input for each."""
    found = [levels_of(bits) for bits in itertools.product((0, 1), repeat=len(LEVELS))]
    return [(levels, given(levels)) for levels in found]


@functools.cache
def _way(goal):
    """Inputs that lead a machine to a state by the causes of the shortest path, one at a time; the last levels."""
    quiet = levels_of([0] * len(LEVELS))
    sets = {
        "power_on": {"power": 1}, "home": {"home": 1}, "at_home": {"at_home": 1}, "follow": {"follow": 1},
        "aligned": {"aligned": 1}, "clutch": {"clutch": 1}, "camera": {"camera": 1}, "hold": {"hold": 1},
        "fault": {"fault": 1}, "recover": {"recover": 1, "fault": 0}, "execute": {"execute": 1},
    }  # fmt: skip
    levels, inputs = quiet, []
    for cause in machine.path("off", goal):
        levels = levels | sets[cause]
        inputs.append(given(levels))
    return inputs, levels


def driven_to(goal):
    """A machine in a state, and the levels that led there."""
    m, (inputs, levels) = _core.SessionMachine(), _way(goal)
    for one in inputs:
        m.step(one)
    assert m.state == goal
    return m, levels


@pytest.mark.parametrize("state", machine.NAMES)
def test_every_state_walks_the_table_under_all_levels(state):
    """All 8192 combinations of levels that differ from those of the state, against a walk of the published table."""
    for levels, given_levels in _inputs():
        m, _ = driven_to(state)
        assert m.step(given_levels) == walk(state, levels)


def test_a_wrong_table_is_noticed():
    wrong = tuple(row for row in machine.TRANSITIONS if row[:2] != ("following", "fault"))
    levels = levels_of([1, 1, 1, 1, 1, 0, 0, 0, 1, 0, 0, 0, 0])
    assert walk("following", levels) == "fault" != walk("following", levels, wrong)


def test_every_row_is_needed_and_every_state_can_be_left_and_reached():
    first = set()
    for state, (levels, _) in itertools.product(machine.NAMES, _inputs()):
        first.add(next(((state, *r) for r in _rows(machine.TRANSITIONS)[state] if HOLDS[r[0]](levels)), None))
    assert first - {None} == set(machine.TRANSITIONS), "a row that no levels can take is dead"
    for a, b in itertools.permutations(machine.NAMES, 2):
        assert machine.path(a, b)


def test_power_off_and_fault_come_before_anything_else():
    for state in machine.NAMES:
        rows = [cause for before, cause, _ in machine.TRANSITIONS if before == state]
        assert "off" in state or rows[0] == "power_off"
        assert state in ("off", "fault") or rows[1] == "fault"


def test_arms_that_are_ready_follow_at_once_and_only_then():
    m = _core.SessionMachine()
    assert m.state == "off"
    assert m.step(_core.SessionInput()) == "following"
    for name, value in (("power", False), ("at_home", False), ("follow", False), ("clutch", True), ("fault", True)):
        m, levels = _core.SessionMachine(), _core.SessionInput()
        setattr(levels, name, value)
        assert m.step(levels) != "following", name


@pytest.mark.parametrize("state", machine.NAMES)
def test_a_request_is_legal_exactly_if_it_changes_the_state(state):
    for request in machine.REQUESTS:
        if request in machine.legal(state):
            machine.require(state, request)
            assert any(row[:2] == (state, request) for row in machine.TRANSITIONS)
            continue
        with pytest.raises(StateError) as refused:
            machine.require(state, request)
        assert state in refused.value.what
        assert refused.value.why == machine.STATES[state]
        for other in machine.legal(state):
            assert other in refused.value.mend


def test_unknown_request_is_named_with_the_nearest():
    with pytest.raises(StateError, match="did you mean 'clutch'"):
        machine.require("following", "cluch")
    with pytest.raises(StateError, match="requests: power_on"):
        machine.require("following", "xyz")


def test_every_fault_says_how_to_leave_it():
    assert set(HOW_TO_LEAVE) == set(STATUS) - NO_FAULTS
    words = how_to_leave(STATUS["leader_stale"][0] | STATUS["lagging"][0] | STATUS["clutched"][0])
    assert HOW_TO_LEAVE["leader_stale"] in words
    assert HOW_TO_LEAVE["lagging"] in words
    assert how_to_leave(STATUS["clutched"][0]) == ""


# -- in a session ----------------------------------------------------------------------------------------------------

SCENE = """
objects:
  - {name: floor, plane: {}, stiffness: 400, damping: 2}
operator:
  path:
    - {t: 0, xyz: [0, 0, 0.004]}
    - {t: 0.3, xyz: [0, 0, -0.004]}
    - {t: 30, xyz: [0, 0, -0.004]}
stability: {force_cap: 6}
"""
AT = {name: k for k, name in enumerate(machine.NAMES)}


@pytest.fixture(scope="module")
def scene():
    return palpate.Scene.parse(SCENE)


def pressed(scene):
    """A session whose tool has been in the floor for a while."""
    session = palpate.Session(scene)
    session.step(600)
    assert session.state.session == "following"
    assert session.state.force > 0.5
    return session


def steps_of(session, ticks):
    """Ticks of the next steps, the last one before them included."""
    rows = [session.latest()]
    for _ in range(ticks):
        rows.append(session.step().tick)
    return np.array(rows)


def jumps(ticks, dt, v_max):
    """Largest change of the force over its cap and of the tool goal over that of the fastest tool, per tick."""
    F, p = ticks["F_H_L"], ticks["p_WT_goal"]
    cap = _core.StabilityOptions().rate_cap * dt
    return (
        float(np.linalg.norm(np.diff(F, axis=0), axis=1).max() / cap),
        float(np.linalg.norm(np.diff(p, axis=0), axis=1).max() / (v_max * dt)),
    )


SEQUENCES = {
    "clutch": ["clutch", "unclutch"],
    "camera": ["camera", "uncamera"],
    "camera over clutch": ["clutch", "camera", "uncamera"],
    "stop": ["stop", "follow"],
    "hold": ["hold", "resume"],
    "hold while clutched": ["clutch", "hold", "resume"],
    "power": ["power_off", "power_on"],
}


@pytest.mark.parametrize("name", SEQUENCES)
def test_no_transition_makes_a_step_of_force_or_pose(scene, name):
    session, seen = pressed(scene), set()
    for request in SEQUENCES[name]:
        session.request(request)
        ticks = steps_of(session, 250)
        force, pose = jumps(ticks, 1e-3, v_max=0.3)
        assert force <= 1.0 + 1e-9
        assert pose <= 1.0
        states = {machine.name_of(x) for x in ticks["session_state"]}
        seen |= states
        held = ticks["session_state"] != AT["following"]
        held[0] = False
        assert not np.any(np.diff(ticks["p_WT_goal"][held], axis=0)), "the goal rests outside of following"
        if held[-1]:
            assert np.linalg.norm(ticks["F_H_L"][-1]) == 0.0
    assert len(seen) > 1


def test_a_step_would_be_noticed(scene):
    ticks = steps_of(pressed(scene), 20)
    for signal, jump in (("F_H_L", 0.5), ("p_WT_goal", 1e-3)):
        wrong = ticks.copy()
        wrong[signal][10:] += [jump, 0, 0]
        assert max(jumps(wrong, 1e-3, 0.3)) > 1.0
    assert max(jumps(ticks, 1e-3, 0.3)) <= 1.0


def test_illegal_requests_change_nothing_and_say_what_is_possible(scene):
    session = pressed(scene)
    session.request("hold")
    session.step()
    with pytest.raises(StateError, match="the session is hold") as refused:
        session.request("clutch")
    assert "resume" in refused.value.mend
    assert not session.controls.clutch
    session.request("resume")
    session.step()
    assert session.state.session == "following"


def test_a_session_before_its_first_tick_is_off(scene):
    session = palpate.Session(scene)
    assert session.state.session == "off"
    with pytest.raises(StateError, match="the session is off"):
        session.request("clutch")


def cycle_of(scene):
    rig = palpate.scene.rig.build(scene)
    arms = rig.arms
    return rig, _core.Cycle(rig.options(), arms.leader, arms.follower)


def test_a_fault_waits_for_its_request_where_the_scene_says_so(scene):
    rig, cycle = cycle_of(scene)
    controls = _core.Controls()
    controls.recover_by_itself = False

    def step(k, valid=True):
        q, v = rig.arms.q_leader0, np.zeros(rig.arms.leader.n)
        row, *_ = cycle.step(1e-3 * k, q, v, 0.0, rig.arms.q_follower0, 0.0, rig.snapshot, controls, leader_valid=valid)
        return machine.name_of(palpate.record.ticks.as_ticks(np.asarray(row).reshape(1, -1))[0]["session_state"])

    assert step(0) == "following"
    assert step(1, valid=False) == "fault"
    assert step(2) == "fault", "the cause is gone, but nobody has agreed to leave"
    machine.apply(controls, "recover")
    assert step(3, valid=False) == "fault", "the cause is back"
    assert step(4) == "following"
    controls.recover_by_itself = True
    assert [step(5, valid=False), step(6)] == ["fault", "following"]


def test_picture_and_tables_of_the_page_are_current():
    tool = Path(__file__).resolve().parents[2] / "tools" / "session_picture.py"
    spec = importlib.util.spec_from_file_location("session_picture", tool)
    drawn = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(drawn)
    text = drawn.PAGE.read_text(encoding="utf-8")
    assert drawn.PICTURE.read_text(encoding="utf-8") == drawn.picture(), "python tools/session_picture.py"
    assert text == drawn.page(text), "python tools/session_picture.py"
    for at, cause, to in machine.TRANSITIONS:  # all rows are in the picture: as an arrow, or in a line
        states = drawn.shared().get((cause, to))
        assert (at in states) if states else (f">{cause}</text>" in drawn.picture())

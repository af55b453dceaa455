"""Exchange of an instrument: continuity, kinematics of the new tool, jaws that stay closed, and refusals."""

import numpy as np
import pytest
from two_pairs import TWO

import palpate
from palpate import _core
from palpate.base.errors import PalpateError, StateError
from palpate.record import Record
from palpate.scene import Scene
from palpate.session import PairsSession, machine

SCENE = """\
objects: [{shape: organ, triangles: 3000, stiffness: 300, damping: 2}]
operator: {palpate: {force: 1, approach: 0.3, press: 0.2, slide: 0.2, leave: 0.3}}
"""
IN_TISSUE, FREE = 550, 1000  # ticks
RATE_CAP = _core.StabilityOptions().rate_cap * 1e-3  # per tick [N]


def held(ticks, text=SCENE, out=None):
    """A session that has run for some ticks and then holds without a force."""
    session = palpate.Session(Scene.parse(text), out=out)
    session.step(ticks)
    session.console.begin_tool_exchange()
    session.step(200)
    return session


def rows(session, n):
    return np.array([session.step().tick for _ in range(n)])


def test_the_new_tool_holds_then_follows_without_a_step(tmp_path):
    session = held(FREE, out=tmp_path)
    console, first = session.console, session.record
    session.exchange_tool("psm_prograsp")
    assert session.console is console
    hold = rows(session, 20)
    assert {machine.name_of(x) for x in hold["session_state"]} == {"hold"}
    assert not hold["F_H_L"].any(), "the old record ends and the new one begins without a force"
    assert not np.ptp(hold["p_WT_goal"], axis=0).any()
    session.console.end_tool_exchange()
    after = rows(session, 700)
    assert machine.name_of(after["session_state"][-1]) == "following"
    force = np.linalg.norm(np.diff(np.r_[hold[-1:], after]["F_H_L"], axis=0), axis=1)
    assert np.linalg.norm(after["F_H_L"], axis=1).max() > 0.2, "the new tool touches the organ"
    assert force.max() <= RATE_CAP * (1 + 1e-9)
    assert (
        np.linalg.norm(np.diff(np.r_[hold[-1:], after]["p_WT_goal"], axis=0), axis=1).max() < 0.6e-3
    )  # 0.6 m/s: the slide is as fast
    summary = session.close()
    assert summary.instrument == "psm_prograsp"
    assert session.record != first
    models = [Scene.parse(Record.open(path).scene).arms.follower.model for path in (first, session.record)]
    assert models == ["psm_lnd", "psm_prograsp"]


def test_the_new_tool_has_its_own_kinematics():
    session = held(FREE)
    session.exchange_tool("psm_prograsp")
    tick, X_WB = session.step(5).tick, session.rig.arms.X_WB
    tips = {}
    for name in ("lnd", "prograsp"):
        arm = palpate.Arm.psm(name)
        tips[name] = (X_WB @ arm.fk(tick["q_follower"][: arm.n]))[:3, 3]
    np.testing.assert_allclose(tick["p_WT"], tips["prograsp"], atol=1e-9)
    straight = np.zeros(6)
    lengths = [-palpate.Arm.psm(name).fk(straight)[2, 3] for name in ("lnd", "prograsp")]
    assert lengths[1] - lengths[0] == pytest.approx(0.0107 - 0.0091, abs=1e-9), "the table's distance of the wrist axes"
    assert np.linalg.norm(tips["lnd"] - tips["prograsp"]) == pytest.approx(0.0016, abs=1e-6)


@pytest.mark.parametrize("ratchet", [True, False])
def test_the_new_jaws_do_not_open_by_themselves(ratchet, monkeypatch):
    """The gripper is half open; without the ratchet the jaws open, which the judgement must see."""
    session = held(FREE)
    if not ratchet:
        from palpate.session import tool_exchange

        mounted = tool_exchange.mounted
        plain = {"mapping.ratchet": False}
        monkeypatch.setattr(tool_exchange, "mounted", lambda *a: palpate.scene.overrides.override(mounted(*a), plain))
    session.exchange_tool("psm_prograsp")
    session.console.end_tool_exchange()
    jaw = rows(session, 400)["jaw"]
    assert (np.abs(jaw).max() < 1e-9) == ratchet


@pytest.mark.parametrize(
    ("ticks", "model", "text", "why"),
    [
        (IN_TISSUE, "psm_prograsp", SCENE, "touches an object"),
        (FREE, "psm_scissors", SCENE, "there is no instrument 'psm_scissors'"),
        (FREE, "none.yaml", SCENE, "there is no instrument 'none.yaml'"),
        (FREE, "mtm_right", SCENE, "mtm_right is no instrument for the arm of psm_lnd"),
        (FREE, "psm_lnd", SCENE, "mounted already"),
        (FREE, "psm_prograsp", SCENE + "arms: {follower: {jaw: {closed: -0.6}}}", "does not fit"),
    ],
)
def test_refusals_change_nothing(ticks, model, text, why):
    session = held(ticks, text)
    loop, tick = session.simulation, session.latest()
    with pytest.raises(StateError, match=why):
        session.exchange_tool(model)
    assert session.simulation is loop
    assert session.latest()["t"] == tick["t"]
    session.console.end_tool_exchange()
    assert session.step(50).session == "following"


def test_an_exchange_needs_a_hold_without_force_and_a_session_that_does_not_run():
    session = palpate.Session(Scene.parse(SCENE))
    session.step(IN_TISSUE)
    with pytest.raises(StateError, match="the session is following"):
        session.exchange_tool("psm_prograsp")
    session.console.begin_tool_exchange()
    session.step(2)
    with pytest.raises(StateError, match="still feels"):
        session.exchange_tool("psm_prograsp")
    session.start()
    try:
        with pytest.raises(StateError, match="runs"):
            session.exchange_tool("psm_prograsp")
    finally:
        session.stop()


def test_one_of_two_pairs_gets_another_instrument():
    quick = "operator: {palpate: {approach: 0.3, press: 0.2}}\n"
    session = PairsSession(Scene.parse(quick + TWO))
    session.step(50)
    session.console.begin_tool_exchange()
    session.step(200)
    with pytest.raises(PalpateError, match="there is no pair 'middle'"):
        session.exchange_tool("psm_prograsp", "middle")
    console = session.console
    session.exchange_tool("psm_prograsp", "left")
    assert session.console is console
    assert [one.rig.arms.follower.name for one in session.pairs.values()] == ["psm_lnd", "psm_prograsp"]
    assert {state.session for state in session.step(5).values()} == {"hold"}
    session.console.end_tool_exchange()
    assert {state.session for state in session.step(50).values()} == {"following"}
    assert session.close().pairs["left"].instrument == "psm_prograsp"

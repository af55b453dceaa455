"""Fixtures of guidance in the certificate: their limit against the whole simulation; beside objects; the entry."""

import itertools

import numpy as np
import pytest

import palpate
from palpate import _core
from palpate.certificate import certify_all
from palpate.certificate.arms import Held
from palpate.certificate.entry import entries, stiffness
from palpate.certificate.guidance import at_once, pulled
from palpate.record.ticks import as_ticks
from palpate.scene.rig import build

SCENE = """
objects: [{name: table, plane: {size: 0.3}, stiffness: 800, damping: 1, pose: {xyz: [0, 0, -0.05]}}]
operator: {path: [{t: 0, xyz: [0, 0, 0.02]}, {t: 1, xyz: [0, 0, 0.019]}]}
loop_delay: DELAY
stability: {passivity: "off", force_cap: 1000, rate_cap: 1000000}
"""


def rig(delay=0.006, fixtures=()):
    made = build(palpate.Scene.parse(SCENE.replace("DELAY", str(delay))))
    object.__setattr__(made, "fixtures", _core.Fixtures(list(fixtures)))
    return made


def wall(K, B, z=0.0, name="wall", role="forbid"):
    X = np.eye(4)
    X[2, 3] = z
    law = _core.GuidanceLawOptions()
    law.K, law.B = K, B
    geometry = _core.PlacedGeometry(_core.SurfaceGeometry(_core.Plane()), X)
    return _core.Fixture(name, geometry, role, law_options=law)


def press(made, K, B):
    """Height of the handle while the hand pushes the tool quickly into a wall and stays; joints at the end."""
    o, arms = made.options(), made.arms
    leader_options = o.leader
    leader_options.coulomb, leader_options.quantised = np.zeros(arms.leader.n), False
    o.leader = leader_options
    tip = (arms.X_WB @ arms.follower.fk(arms.q_follower0))[:3, 3]
    down = 0.002 + 1.0 / K + o.mapping.scale / o.hand.stiffness
    way = np.array([tip, tip, tip - [0, 0, down], tip - [0, 0, down]])
    path = _core.HandPath([0.0, 0.2, 0.28, 9.0], way)
    simulation = _core.Simulation(o, arms.leader, arms.leader, arms.follower, _core.Snapshot([]), path)
    simulation.set_fixtures(_core.Fixtures([wall(K, B, tip[2] - 0.002)]))
    ticks = as_ticks(simulation.run(3000))
    return ticks["p_LH"] @ arms.X_WL[:3, :3].T[:, 2], ticks["q"][-1][: arms.leader.n]


def swings(made, K, B):
    size = [0.5 * float(np.ptp(part)) for part in np.array_split(press(made, K, B)[0][1500:], 6)]
    return size[-1] > 2e-5 and any(b > 0.98 * a for a, b in itertools.pairwise(size))


def test_the_whole_simulation_swings_above_a_fixtures_limit_and_rests_below():
    made, B = rig(), 5.0
    _, q = press(made, 100.0, B)
    o = made.options()
    n = made.arms.X_WL[:3, :3].T[:, 2]
    k, _ = Held(made.arms.leader, q, o, o.hand, fixture=True).loop(n).K_max(B)
    assert not swings(made, 0.93 * k, B)
    assert swings(made, 1.07 * k, B)


def test_each_fixture_has_a_row_and_several_have_one_together():
    made = rig(fixtures=[wall(300.0, 1.0), wall(500.0, 2.0, name="two"), wall(1.0, 1.0, name="o", role="orient")])
    rows = certify_all(made.scene, rig=made)
    assert [row.name for row in rows] == ["table", "fixture wall", "fixture two", "all fixtures at once"]
    assert rows[-1].K == 800.0
    assert at_once(made.fixtures.list()) == 800.0
    assert rows[1].k_max > certify_all(rig().scene, rig=rig())[0].k_max, "no servo in a fixture's loop"


def test_what_is_off_or_has_no_authority_does_not_count():
    off, none = wall(300.0, 1.0), wall(500.0, 2.0, name="two")
    policy = _core.Policy()
    policy.authority = 0.0
    made = [
        _core.Fixture("a", _core.SurfaceGeometry(_core.Plane()), "forbid", on=False),
        _core.Fixture("b", _core.SurfaceGeometry(_core.Plane()), "forbid", policy=policy),
    ]
    assert pulled(made) == []
    assert [f.K for f in pulled([off, none])] == [300.0, 500.0, 800.0]


def test_a_fixture_beside_it_counts_in_an_objects_loop():
    """Two springs of the same kind in one loop: the limit of their sum, whichever is asked about."""
    made = rig()
    o, n = made.options(), np.array([0.0, 0.0, 1.0])
    held = Held(made.arms.leader, made.arms.q_leader0, o, o.hand, fixture=True)
    k = held.loop(n).K_max(2.0)[0]
    beside = Held(made.arms.leader, made.arms.q_leader0, o, o.hand, fixture=True, beside=0.4 * k).loop(n).K_max(2.0)[0]
    assert beside == pytest.approx(0.6 * k, rel=0.01)
    too_much = Held(made.arms.leader, made.arms.q_leader0, o, o.hand, fixture=True, beside=1.1 * k)
    assert too_much.loop(n).K_max(2.0)[0] == 0.0


def test_what_cannot_be_held_says_what_can():
    made = rig(0.02, [wall(20000.0, 2.0)])
    row = certify_all(made.scene, rig=made)[1]
    assert row.verdict == "unstable"
    assert "softly it can hold so much: 1, 2, 3 N get" in row.reason
    assert "with hard: true the tool stays out" in row.reason


def test_the_entry_is_the_certified_stiffness_to_five_percent():
    for one in entries(rig(0.0), 300.0, 2.0):
        assert one.certified_mm == pytest.approx(1e3 * one.force_N / 300.0)
        assert one.measured_mm == pytest.approx(one.certified_mm, rel=0.05)


def test_the_stiffness_that_is_measured_is_that_of_the_fixture_in_its_place():
    """By load cell and depth: of a plane that is put there, or of the rig's own fixture, whatever was asked about."""
    arms, scale = rig(0.0).arms, rig(0.0).options().mapping.force_scale
    at = (arms.X_WB @ arms.follower.fk(arms.q_follower0))[:3, 3] - [0.0, 0.0, 0.004]
    made = rig(0.0, [wall(200.0, 2.0, at[2])])
    assert stiffness(entries(made, 300.0, 2.0), scale) == pytest.approx(300.0, rel=0.01)
    assert stiffness(entries(made, 300.0, 2.0, at), scale) == pytest.approx(200.0, rel=0.01)

"""Guidance fixtures in the certificate: limit against the full simulation, parallel objects, and penetration."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

import palpate
from palpate import _core, _guidance
from palpate.devices.certificate import certify_all
from palpate.devices.certificate.arms import HeldLeader, felt
from palpate.devices.certificate.entry import entries, stiffness
from palpate.devices.certificate.guidance import entry, entry_summary, fixture_springs, total_stiffness
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
    object.__setattr__(made, "fixtures", _guidance.Fixtures(list(fixtures)))
    return made


def wall(K, B, z=0.0, name="wall", role="forbid"):
    X = np.eye(4)
    X[2, 3] = z
    law = _core.GuidanceLawOptions()
    law.K, law.B = K, B
    geometry = _guidance.PlacedGeometry(_guidance.SurfaceGeometry(_core.Plane()), X)
    return _guidance.Fixture(name, geometry, role, law_options=law)


def press(made, K, B):
    """Height of the handle [m] while the hand quickly pushes the tool into a wall and stays; joints at the end."""
    o, arms = made.options(), made.arms
    leader_options = o.leader
    leader_options.coulomb, leader_options.quantised = np.zeros(arms.leader.n), False
    o.leader = leader_options
    tip = (arms.X_WB @ arms.follower.fk(arms.q_follower0))[:3, 3]
    down = 0.002 + 1.0 / K + o.mapping.scale / o.hand.stiffness
    positions = np.array([tip, tip, tip - [0, 0, down], tip - [0, 0, down]])
    path = _core.HandPath([0.0, 0.2, 0.28, 9.0], positions)
    simulation = _core.Simulation(o, arms.leader, arms.leader, arms.follower, _core.Snapshot([]), path)
    simulation.set_fixtures(_guidance.Fixtures([wall(K, B, tip[2] - 0.002)]))
    ticks = as_ticks(simulation.run(3000))
    return ticks["p_LH"] @ arms.X_WL[:3, :3].T[:, 2], ticks["q"][-1][: arms.leader.n]


def swings(made, K, B):
    size = [0.5 * float(np.ptp(part)) for part in np.array_split(press(made, K, B)[0][1500:], 6)]
    return size[-1] > 2e-5 and any(b > 0.98 * a for a, b in itertools.pairwise(size))


def test_full_simulation_oscillates_above_a_fixture_limit_and_settles_below():
    made, B = rig(), 5.0
    _, q = press(made, 100.0, B)
    o = made.options()
    n = made.arms.X_WL[:3, :3].T[:, 2]
    k, _ = HeldLeader(made.arms.leader, q, o, o.hand, fixture=True).loop(n).K_max(B)
    assert not swings(made, 0.93 * k, B)
    assert swings(made, 1.07 * k, B)


def test_each_fixture_and_their_sum_have_a_certificate():
    made = rig(fixtures=[wall(300.0, 1.0), wall(500.0, 2.0, name="two"), wall(1.0, 1.0, name="o", role="orient")])
    rows = certify_all(made.scene, rig=made)
    assert [row.name for row in rows] == ["table", "fixture wall", "fixture two", "all fixtures at once"]
    assert rows[-1].K == 800.0
    assert total_stiffness(made.fixtures.list()) == 800.0
    parallel = [row.cases[0].loop.parallel_stiffness for row in rows]
    assert parallel == [pytest.approx(felt(made.options()) * 800.0), 0.0, 0.0, 0.0], "with the touched object alone"
    assert rows[1].k_max > certify_all(rig().scene, rig=rig())[0].k_max, "no servo in a fixture's loop"


def test_inactive_fixtures_are_ignored():
    off, none = wall(300.0, 1.0), wall(500.0, 2.0, name="two")
    policy = _core.Policy()
    policy.authority = 0.0
    made = [
        _guidance.Fixture("a", _guidance.SurfaceGeometry(_core.Plane()), "forbid", on=False),
        _guidance.Fixture("b", _guidance.SurfaceGeometry(_core.Plane()), "forbid", policy=policy),
    ]
    assert fixture_springs(made) == []
    assert [f.K for f in fixture_springs([off, none])] == [300.0, 500.0, 800.0]


def test_parallel_fixture_stiffness_reduces_an_objects_limit():
    """Two springs of the same kind in one loop: the limit applies to the sum of their stiffnesses."""
    made = rig()
    o, n = made.options(), np.array([0.0, 0.0, 1.0])
    held = HeldLeader(made.arms.leader, made.arms.q_leader0, o, o.hand, fixture=True)
    k = held.loop(n).K_max(2.0)[0]
    parallel = replace(held, parallel_stiffness=0.4 * k)
    assert parallel.loop(n).K_max(2.0)[0] == pytest.approx(0.6 * k, rel=1e-6)
    too_much = replace(held, parallel_stiffness=1.1 * k)
    assert too_much.loop(n).K_max(2.0)[0] == 0.0


def test_reason_for_an_unstable_fixture_states_the_soft_depth():
    made = rig(0.02, [wall(20000.0, 2.0)])
    row = certify_all(made.scene, rig=made)[1]
    assert row.verdict == "unstable"
    assert "softly it can hold so much: 1, 2, 3 N get" in row.reason
    assert "with hard: true the tool stays out" in row.reason


def test_penetration_matches_the_certified_stiffness_within_five_percent():
    for press in entries(rig(0.0), 300.0, 2.0):
        assert press.certified_mm == pytest.approx(1e3 * press.force_N / 300.0)
        assert press.measured_mm == pytest.approx(press.certified_mm, rel=0.05)


def test_measured_stiffness_is_that_of_the_pressed_fixture():
    """Slope of the load cell's force over the depth, for an added plane and for the rig's own fixture."""
    arms, scale = rig(0.0).arms, rig(0.0).options().mapping.force_scale
    at = (arms.X_WB @ arms.follower.fk(arms.q_follower0))[:3, 3] - [0.0, 0.0, 0.004]
    made = rig(0.0, [wall(200.0, 2.0, at[2])])
    assert stiffness(entries(made, 300.0, 2.0), scale) == pytest.approx(300.0, rel=0.01)
    assert stiffness(entries(made, 300.0, 2.0, at), scale) == pytest.approx(200.0, rel=0.01)


def test_sums_of_fixtures_count_each_with_its_authority():
    """A fixture with authority a renders a times its force, so its spring and damper are a K and a B."""
    made = []
    for i, (authority, K, B) in enumerate(((0.5, 300.0, 1.0), (0.25, 800.0, 4.0))):
        policy, law = _core.Policy(), _core.GuidanceLawOptions()
        policy.authority, law.K, law.B = authority, K, B
        plane = _guidance.SurfaceGeometry(_core.Plane())
        made.append(_guidance.Fixture(f"f{i}", plane, "forbid", law_options=law, policy=policy))
    assert [(f.K, f.B) for f in fixture_springs(made)] == [(150.0, 0.5), (200.0, 1.0), (350.0, 1.5)]
    assert total_stiffness(made) == 350.0


def test_penetration_is_the_deflection_of_a_spring():
    """3 N of the hand against 500 N/m on the tool with forces doubled for the hand: 3 / 2 / 500 m."""
    assert entry(3.0, 500.0, 2.0) == pytest.approx(3e-3)
    assert entry_summary(500.0, 2.0) == "1, 2, 3 N get 1, 2, 3 mm in"


def test_a_fixture_of_too_much_damping_holds_at_no_stiffness():
    made = rig(0.02, [wall(300.0, 3000.0)])
    row = certify_all(made.scene, rig=made)[1]
    assert (row.verdict, row.k_max) == ("unstable", 0.0)
    assert "too much damping, whatever the stiffness" in row.reason
    assert "softly" not in row.reason

"""Fixtures in the full simulation of arms, servo and hand: penetration, certified stiffness, energy, signals."""

import sys
from pathlib import Path

import numpy as np
import pytest
from fixtures import fixture, placed, plane, pose, sphere
from scipy.spatial.transform import Rotation

from palpate import _core, _guidance

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "loop"))
import loop_rig

NOTHING = _core.Snapshot([])
CORRECTED = 1 << 21


def simulation(path, *fixtures, **changes):
    sim = loop_rig.simulation(NOTHING, path, **changes)
    sim.set_fixtures(_guidance.Fixtures(list(fixtures)))
    return sim


def hand_path(points, times):
    return _core.HandPath(list(times), np.asarray(points, float))


def violent_hand(seed, seconds=3.0):
    """A violent hand motion: waypoints every 60 to 200 ms, some of them deep below the floor."""
    rng = np.random.default_rng(seed)
    times = np.concatenate([[0.0, 0.5], 0.5 + np.cumsum(rng.uniform(0.06, 0.2, 40))])
    times = times[times < seconds]
    points = rng.uniform([-0.03, -0.03, -0.06], [0.03, 0.03, 0.03], (len(times), 3))
    points[:2] = [0.0, 0.0, 0.012]
    return hand_path(points, times)


@pytest.mark.parametrize("kind", ["floor", "slope", "vessel", "room", "breathing floor", "breathing vessel"])
def test_tool_stays_outside_during_violent_hand_motions(kind):
    """The tool enters by at most 0.1 mm, with joint servos, encoders and a firm grip; the caps hold."""
    waves = [_core.Wave(shift=np.array([0.001, 0.0, 0.003]), turn=np.zeros(3), period=1.5)]
    motion = _core.Motion(waves=waves) if "breathing" in kind else None
    if kind.endswith("floor"):
        f = fixture(plane(motion=motion), hard=True)
    elif kind == "slope":
        f = fixture(plane(pose([0.0, 0.0, 0.004], Rotation.from_rotvec([0.0, 0.96, 0.1]).as_matrix())), hard=True)
    elif kind.endswith("vessel"):
        f = fixture(placed(_guidance.LineGeometry(np.array([-1.0, 0, 0]), np.array([1.0, 0, 0]), True), None, motion),
                    role_={"margin": 0.006}, hard=True)  # fmt: skip
    else:
        f = fixture(sphere(0.02, pose([0.0, 0.0, 0.012])), "keep-in", hard=True)
    ticks = loop_rig.run(simulation(violent_hand(3), f, hand__stiffness=600.0, hand__grip_force_max=60.0), 3.0)
    X = np.tile(np.eye(4), (len(ticks), 1, 1))
    X[:, :3, 3] = ticks["p_WT"]
    gap = np.array([f.evaluate(x, t)["gap"] for x, t in zip(X, ticks["t"], strict=True)])
    assert gap.min() > -1e-4, f"{-1e3 * gap.min():.3f} mm in"
    corrected = (ticks["status"].astype(int) & CORRECTED) != 0
    assert corrected.mean() > 0.2, "control: the hand pressed on the fixture"
    assert np.linalg.norm(ticks["v_LH"], axis=1).max() > 0.3, "control: the motion was violent"
    assert np.linalg.norm(ticks["F_H_L"], axis=1).max() <= 3.0 + 1e-9


@pytest.mark.parametrize("force", [1.0, 2.0, 3.0])
def test_penetration_of_a_soft_fixture_matches_its_stiffness(force):
    """A hand that presses with 1, 2, 3 N penetrates by force / (force_scale K), measured at the tool, to 5 %."""
    K = 300.0
    o = loop_rig.options()
    entry = force / (o.mapping.force_scale * K)
    spring = o.hand.stiffness
    # The force stretches the hand's spring; on the tool's side the stretch is multiplied by scale.
    target = -entry - o.mapping.scale * force / spring
    path = hand_path([[0, 0, 0.012], [0, 0, 0.002], [0, 0, target], [0, 0, target]], [0.0, 0.3, 1.5, 3.0])
    ticks = loop_rig.run(simulation(path, fixture(plane(), law_={"K": K}), stability__force_cap=6.0), 4.0)[-500:]
    felt = ticks["F_H_L"].mean(axis=0)
    assert np.linalg.norm(felt) == pytest.approx(force, rel=0.35), "control: the force is close to the commanded one"
    found = -ticks["p_WT"][:, 2].mean()
    assert found == pytest.approx(np.linalg.norm(felt) / (o.mapping.force_scale * K), rel=0.05)


def test_guidance_has_its_own_energy_account_and_the_ledger_adds_up():
    path = hand_path([[0, 0, 0.012], [0, 0, -0.004], [0.01, 0, -0.004], [0.01, 0, 0.012]], [0.0, 0.8, 1.6, 2.4])
    ticks = loop_rig.run(simulation(path, fixture(plane(), law_={"K": 300.0})), 3.0)
    source = ticks["energy_source"]
    assert source[:, -2].max() > 1e-4, "the hand has put in energy"
    assert source[-1, -2] > -1e-6, "the hand gets no more energy back"
    np.testing.assert_allclose(source[:, :-2], 0.0, atol=1e-12)
    kept = ticks["energy_port"] + sum(
        ticks[f"energy_{name}"] for name in ("cut", "passivity", "low_pass", "coupling")
    )  # fmt: skip
    np.testing.assert_allclose(source.sum(axis=1), kept, atol=1e-12)


PASSIVITY = 1 << 13


@pytest.mark.parametrize("ramped", [False, True])
def test_potential_well_switched_on_is_credited_with_its_depth_only(ramped):
    """Depth at the tool: 1.25 + 5.5 + 1 mJ, for K = 400 N/m up to 1 N and a range of 10 mm that fades over 2 mm."""
    depth = 0.5 * 400 * 0.0025**2 + 1.0 * (0.008 - 0.0025) + 0.5 * 1.0 * 0.002
    line = _guidance.LineGeometry(np.array([-1.0, 0, 0.024]), np.array([1.0, 0, 0.024]), True)
    ramp = _core.Ramp("distance", 1.0, 0.5)  # the factor is 1 here, but it could depend on the hand
    well = fixture(placed(line), "guide", "potential", law_={"K": 400.0, "force": 1.0, "range": 0.01},
                   ramps=[ramp] if ramped else [])  # fmt: skip
    path = hand_path([[0, 0, 0.012], [0, 0, 0.012], [0, 0, 0.023]], [0.0, 0.5, 1.5])
    ticks = loop_rig.run(simulation(path, well), 2.5)
    o = loop_rig.options()
    acted = ((ticks["status"].astype(int) & PASSIVITY) != 0).any()
    if ramped:
        assert (ticks["energy_lent"] == 0.0).all()
        assert acted, "control: without the credit the passivity layer acts"
    else:
        hands = depth * o.mapping.force_scale / o.mapping.scale
        assert ticks["energy_lent"][-1] == pytest.approx(hands, rel=1e-3)
        assert ticks["energy_port"].min() < -0.5 * hands, "control: the well pulled the hand"
        assert ticks["energy_port"].min() > -hands - 5e-4, "at most the depth and the allowance"
        assert not acted


def test_signals_name_the_active_fixture():
    path = hand_path([[0, 0, 0.012], [0, 0, -0.004], [0, 0, -0.004]], [0.0, 0.8, 1.6])
    made = [fixture(sphere(0.5), "keep-in", name="room"), fixture(plane(), name="floor", hard=True)]
    ticks = loop_rig.run(simulation(path, *made), 2.0)
    assert ticks["guidance_fixture"][0] == -1
    assert ticks["guidance_fixture"][-1] == 1
    assert ticks["guidance_gap"][-1] < 0.0
    assert ticks["p_correction_W"][-1, 2] > 0.001
    np.testing.assert_allclose(ticks["F_guidance_W"][-1, :2], 0.0, atol=1e-9)
    assert ticks["F_guidance_W"][-1, 2] > 0.3


def test_clutch_against_a_hard_fixture_releases_and_restarts():
    path = hand_path([[0, 0, 0.012], [0, 0, -0.006], [0, 0, -0.006]], [0.0, 0.8, 1.6])
    sim = simulation(path, fixture(plane(), hard=True))
    loop_rig.run(sim, 1.5)
    controls = sim.controls
    controls.clutch = True
    sim.controls = controls
    held = loop_rig.run(sim, 0.5)
    assert (held["p_WT_goal"][:, 2] >= 0.0).all()
    np.testing.assert_array_equal(held["F_guidance_W"][1:], 0.0)
    controls.clutch = False
    sim.controls = controls
    again = loop_rig.run(sim, 0.2)
    assert np.linalg.norm(again["F_H_L"], axis=1)[:20].max() < 1.1, "no more than the caps' ramp and the hand explain"
    assert (again["p_WT_goal"][:, 2] >= 0.0).all()


def test_empty_list_of_fixtures_leaves_a_run_bit_for_bit_equal():
    path = loop_rig.press_path()
    one = loop_rig.simulation(None, path).run(1500)
    sim = loop_rig.simulation(None, path)
    sim.set_fixtures(_guidance.Fixtures([]))
    other = sim.run(1500)
    columns = [i for i in range(one.shape[1]) if i < one.shape[1] - 2]  # without the two columns of the machine's clock
    np.testing.assert_array_equal(one[:, columns], other[:, columns])


def test_running_loop_takes_its_first_fixture_and_gives_it_up_without_a_step():
    """A loop has no stage before its first fixture; the core's empty list ends the last one's force."""
    deep = [0.0, 0.0, -0.01]
    sim = loop_rig.simulation(NOTHING, hand_path([[0, 0, 0.012], deep, deep], [0.0, 0.5, 9.0]))
    ticks = [loop_rig.run(sim, 1.0)]
    for fixtures in (_guidance.Fixtures([fixture(plane(), law_={"K": 100.0})]), _core.FixtureList()):
        sim.set_fixtures(fixtures)
        ticks.append(loop_rig.run(sim, 1.0))
    before, during, after = (np.linalg.norm(part["F_guidance_W"], axis=1) for part in ticks)
    assert before.max() == 0.0
    assert during[-1] > 0.3, "control: the hand presses on the fixture"
    assert after[-1] == 0.0
    assert np.abs(np.diff(np.concatenate([before, during, after]))).max() < 0.03  # [N] 20 N/s, and the hand's motion


def test_frame_of_the_tool_receives_its_pose_without_fixtures():
    tool = _core.LiveFrame()
    sim = loop_rig.simulation(NOTHING, hand_path([[0, 0, 0.012], [0, 0, 0.02]], [0.0, 0.5]))
    sim.set_fixtures(_core.FixtureList(tool))
    tick = loop_rig.run(sim, 0.4)[-1]
    np.testing.assert_array_equal(tool.at(0.0)[0][:3, 3], tick["p_WT"])


def test_invalid_fixtures_are_rejected_by_the_simulation():
    with pytest.raises(ValueError, match="role forbid needs a geometry with an inside"):
        simulation(violent_hand(1), fixture(placed(_guidance.PointGeometry())))


@pytest.mark.parametrize("along", [True, False])
def test_admittance_master_has_little_damping_along_and_much_across_the_line(along):
    """Force over speed of a steady motion: damping of the virtual handle and, by direction, of the fixture."""
    b, B, ratio = 2.0, 4.0, 0.2
    line = _guidance.LineGeometry(np.array([-1.0, 0, 0.012]), np.array([1.0, 0, 0.012]), True)
    f = fixture(placed(line), "guide", "admittance", law_={"B": B, "ratio": ratio})
    motion = np.array([0.04, 0.0, 0.0] if along else [0.0, 0.04, 0.0])
    path = hand_path([[0, 0, 0.012], [0, 0, 0.012], np.array([0, 0, 0.012]) + motion], [0.0, 0.4, 2.4])
    changes = {"torque__law": "admittance", "torque__laws__virtual_damping": b, "stability__force_cap": 6.0}
    ticks = loop_rig.run(simulation(path, f, **changes), 2.3)
    o = loop_rig.options()
    n = o.X_WL[:3, :3].T @ (motion / 0.04)
    steady = slice(1200, 2000)
    felt = (ticks["F_cell_L"][steady] @ n).mean()
    speed = (ticks["v_LH"][steady] @ n).mean()
    of_fixture = o.mapping.force_scale * o.mapping.scale * (B if along else B / ratio)
    assert -felt / speed == pytest.approx(b + of_fixture, rel=0.15)
    np.testing.assert_allclose(ticks["F_guidance_W"], 0.0, atol=1e-12)


def test_damping_of_an_admittance_master_is_capped_and_accounted_like_a_force():
    """Motion across the line would exceed the cap; the ledger counts the capped force that the hand has received."""
    line = _guidance.LineGeometry(np.array([-1.0, 0, 0.012]), np.array([1.0, 0, 0.012]), True)
    f = fixture(placed(line), "guide", "admittance", law_={"B": 20.0, "ratio": 0.05})
    path = hand_path([[0, 0, 0.012], [0, 0, 0.012], [0, 0.1, 0.012]], [0.0, 0.4, 1.4])
    changes = {"torque__law": "admittance", "stability__force_cap": 1.5, "hand__stiffness": 300.0}
    ticks = loop_rig.run(simulation(path, f, **changes), 1.6)
    felt = np.linalg.norm(ticks["F_H_L"], axis=1)
    assert felt.max() <= 1.5 + 1e-9
    assert felt.max() > 1.4, "control: the cap was reached"
    assert np.linalg.norm(np.diff(ticks["F_H_L"], axis=0), axis=1).max() < 0.2
    power = -(ticks["F_H_L"] * ticks["v_LH"]).sum(axis=1)
    taken = (power * 1e-3).sum()
    assert taken > 0.01, "the hand has done work across the line"
    assert ticks["energy_port"][-1] == pytest.approx(taken, rel=0.1)
    assert ticks["energy_source"][-1, 15] >= ticks["energy_port"][-1], "the guidance force before the caps"

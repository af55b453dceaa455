"""The full simulation in lockstep: motion, forces, stability, reproducibility."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from loop_rig import CLUTCHED, HEIGHT, NOT_FOLLOWING, floor, options, run, simulation

from palpate import _core
from palpate.arm import Arm
from palpate.record.ticks import SIGNALS, STATUS, as_rows, as_ticks

DETERMINISTIC = [name for name, s in SIGNALS.items() if s.deterministic]


def controls(**changes):
    c = _core.Controls()
    for name, value in changes.items():
        setattr(c, name, value)
    return c


def test_two_runs_are_byte_identical():
    a, b = (run(simulation(tremor=1e-4, seed=5), 1.5) for _ in range(2))
    for name in DETERMINISTIC:
        assert a[name].tobytes() == b[name].tobytes(), name


def test_run_in_pieces_equals_one_run():
    whole, pieces = simulation(), simulation()
    a = run(whole, 1.0)
    b = np.concatenate([as_ticks(pieces.run(n)) for n in (1, 99, 400, 500)])
    for name in DETERMINISTIC:
        assert a[name].tobytes() == b[name].tobytes(), name


def test_other_seed_gives_another_tremor():
    a, b = (run(simulation(tremor=2e-4, seed=seed), 0.5)["p_hand_L"] for seed in (1, 2))
    assert np.abs(a - b).max() > 1e-5


def test_tool_follows_the_path_in_free_space():
    times = [0.2, 1.2, 2.2]
    points = np.array([[0, 0, HEIGHT], [0.02, -0.01, 0.03], [-0.01, 0.02, 0.02]])
    ticks = run(simulation(path=_core.HandPath(times, points)), 3.5)
    np.testing.assert_allclose(ticks["p_WT"][-1], points[-1], atol=6e-4)  # deviation by the friction of the arm
    assert not (ticks["status"].astype(int) & ~STATUS["too_fast"][0]).any()  # 90 mm/s may be too fast
    assert not ticks["F_T_W"].any()


def test_contact_is_stable(pressed):
    """The force of a held contact settles without a limit cycle."""
    held = np.linalg.norm(pressed["F_T_W"][1050:1200], axis=1)
    assert held.mean() > 0.3
    assert np.ptp(held) < 0.05 * held.mean()


@pytest.mark.parametrize("K", [300.0, 500.0])
def test_stiff_contacts_settle(K):
    path = _core.HandPath([0.1, 0.8], np.array([[0, 0, HEIGHT], [0, 0, -0.008]]))
    ticks = run(simulation(floor(K=(K, K, K)), path), 3.0)
    held = np.linalg.norm(ticks["F_T_W"][2500:], axis=1)
    assert held.mean() > 0.5
    assert np.ptp(held) < 0.03 * held.mean()


def test_stiffness_at_the_hand_is_scale_times_stiffness():
    """Measured as the change of the force on the hand over the change of the handle position, at rest."""
    ends = []
    for depth in (0.004, 0.008):
        path = _core.HandPath([0.1, 0.8], np.array([[0, 0, HEIGHT], [0, 0, -depth]]))
        ticks = run(simulation(path=path, follower__encoder_step=np.zeros(6)), 3.0)
        ends.append((ticks["p_LH"][-1] @ options().X_WL[:3, :3].T, np.linalg.norm(ticks["F_H_L"][-1])))
    (p0, F0), (p1, F1) = ends
    assert (F1 - F0) / (p0 - p1)[2] == pytest.approx(0.5 * 400.0, rel=0.02)


def test_clutch_in_contact_holds_the_tool_and_releases_the_hand():
    sim = simulation(path=_core.HandPath([0.1, 0.8], np.array([[0, 0, HEIGHT], [0, 0, -0.006]])))
    before = run(sim, 1.5)
    sim.controls = controls(clutch=True, p_hand_offset_W=np.array([0.03, 0.0, 0.02]))
    during = run(sim, 1.5)
    sim.controls = controls(p_hand_offset_W=np.array([0.03, 0.0, 0.02]))
    after = run(sim, 1.5)
    ticks = np.concatenate([before, during, after])
    steps = np.linalg.norm(np.diff(ticks["F_H_L"], axis=0), axis=1)
    force = np.linalg.norm(ticks["F_H_L"], axis=1)
    assert np.diff(force).max() <= 50.0 * 1e-3 + 1e-12
    faster = np.flatnonzero(steps > 50.0 * 1e-3 + 1e-12)  # the passivity controller alone, and only downwards
    assert (np.diff(force)[faster] < 0.0).all()
    assert (ticks["F_withheld"][faster + 1, 2] >= steps[faster] - 50.0 * 1e-3).all()
    goal = np.linalg.norm(np.diff(ticks["p_WT_goal"], axis=0), axis=1)
    hand = np.linalg.norm(np.diff(ticks["p_LH"], axis=0), axis=1)
    assert (goal <= 0.5 * hand + 1e-9).all()  # at most the scaled motion of the hand, without a jump
    assert (during["status"].astype(int) & CLUTCHED).all()
    assert np.ptp(during["p_WT_goal"], axis=0).max() < 1e-9
    assert not during["F_H_L"][200:].any()
    assert np.linalg.norm(during["p_LH"][-1] - before["p_LH"][-1]) > 0.02  # the hand moves away
    assert np.linalg.norm(after["p_WT"][2] - during["p_WT"][-1]) < 1e-4


def test_hold_interrupts_and_resumes_the_hand_path_without_a_jump():
    path = _core.HandPath([0.1, 1.1], np.array([[0, 0, HEIGHT], [0.02, 0, HEIGHT]]))
    sim = simulation(path=path)
    before = run(sim, 0.6)  # half of the path
    sim.controls = controls(hold=True)
    during = run(sim, 1.5)
    sim.controls = controls()
    after = run(sim, 1.5)
    hand = np.concatenate([before, during, after])["p_hand_L"]
    steps = np.linalg.norm(np.diff(hand, axis=0), axis=1)
    assert steps.max() < 1.2 * np.linalg.norm(np.diff(before["p_hand_L"], axis=0), axis=1).max()
    assert np.ptp(during["p_hand_L"][1000:], axis=0).max() < 1e-4  # the hand is at rest
    whole = np.linalg.norm(after["p_hand_L"][-1] - before["p_hand_L"][0])
    assert whole == pytest.approx(0.04, abs=2e-4)  # the whole path: 20 mm of the tool at half scale


def test_engaging_in_contact_ramps_the_force_from_zero():
    X_WB = options().X_WB
    X_WB[2, 3] -= HEIGHT + 0.001
    sim = simulation(path=_core.HandPath([0.0], np.array([[0, 0, -0.001]])), X_WB=X_WB)
    sim.controls = controls(following=False)
    off = run(sim, 0.2)
    assert not off["F_H_L"].any()
    assert (off["status"].astype(int) & NOT_FOLLOWING).all()
    sim.controls = controls()
    on = run(sim, 0.3)
    norms = np.linalg.norm(on["F_H_L"], axis=1)
    assert norms[0] <= 0.05
    assert norms[-1] > 0.2
    assert np.linalg.norm(np.diff(on["p_WT_goal"], axis=0), axis=1).max() < 1e-4


def test_energy_ledger_agrees_with_the_recorded_signals(pressed):
    """Reference: energies computed from the recorded forces and velocities."""
    R_WL = options().X_WL[:3, :3]
    dx = np.diff(pressed["p_LH"], axis=0)

    def energy(F_L):
        return np.concatenate([[0], np.cumsum(-np.einsum("ij,ij->i", F_L[:-1], dx))])

    np.testing.assert_allclose(pressed["energy_port"], energy(pressed["F_H_L"]), atol=1e-12)
    np.testing.assert_allclose(pressed["energy_damping"], energy(pressed["F_damping_W"] @ R_WL), atol=1e-12)
    withheld = pressed["energy_cut"] + pressed["energy_passivity"]
    np.testing.assert_allclose(withheld, energy(pressed["F_T_W"] @ R_WL - pressed["F_H_L"]), atol=1e-12)
    np.testing.assert_allclose(pressed["energy_source"][:, 0], pressed["energy_port"] + withheld, atol=1e-12)
    np.testing.assert_allclose(pressed["energy_source"][:, 1:], 0.0, atol=1e-12)
    spring = 0.5 * np.einsum("ij,ij->i", pressed["F_spring_W"], pressed["delta_x"]) / 0.5
    np.testing.assert_allclose(pressed["energy_spring"], spring, atol=1e-12)


def test_clutched_hand_exchanges_no_energy():
    """While the tool holds, port + cut is constant for any motion of the hand, including the ramp-down."""
    sim = simulation(path=_core.HandPath([0.1, 0.8], np.array([[0, 0, HEIGHT], [0, 0, -0.006]])))
    run(sim, 1.5)
    sim.controls = controls(clutch=True, p_hand_offset_W=np.array([0.03, 0.0, 0.02]))
    ticks = run(sim, 1.5)
    book = ticks["energy_port"] + ticks["energy_cut"]
    assert np.linalg.norm(ticks["F_T_W"][-1]) > 0.3  # the tool is still in contact
    assert np.linalg.norm(ticks["p_LH"][-1] - ticks["p_LH"][0]) > 0.02
    np.testing.assert_allclose(book, book[0], atol=1e-12)


def test_slow_pressing_stores_the_energy_of_the_hand():
    """port + cut = spring + damping while the press is slow and the follower ideal."""
    path = _core.HandPath([0.1, 3.1], np.array([[0, 0, 0.003], [0, 0, -0.006]]))
    X_WB = options().X_WB
    X_WB[2, 3] -= HEIGHT - 0.003
    o = {"follower__bandwidth": 0.0, "follower__encoder_step": np.zeros(6), "X_WB": X_WB}
    ticks = run(simulation(floor(B=(2.0, 2.0, 2.0)), path, **o), 4.0)
    end = ticks[-1]
    assert end["energy_spring"] > 1e-3
    assert end["energy_port"] + end["energy_cut"] == pytest.approx(
        end["energy_spring"] + end["energy_damping"], rel=0.03
    )


def test_loop_delay_delays_the_force_on_the_hand():
    """The delay is between command and torque: commands agree until the first force, which reaches the hand later."""
    o = {"leader__coulomb": np.zeros(7), "leader__quantised": False}
    now, late = (run(simulation(loop_delay=delay, **o), 1.0) for delay in (0.0, 0.02))
    first = [np.argmax(np.linalg.norm(t["F_H_L"], axis=1) > 0) for t in (now, late)]
    assert first[0] == first[1]
    difference = np.linalg.norm(now["p_LH"] - late["p_LH"], axis=1)
    assert not difference[: first[0] + 1].any()
    assert difference[first[0] + 20] > 0


def test_paused_simulation_does_not_change():
    sim = simulation()
    run(sim, 0.1)
    sim.controls = controls(paused=True)
    assert sim.run(100).shape == (0, _core.TICK_BYTES // 8)
    sim.controls = controls()
    assert run(sim, 0.001)["t"][0] == pytest.approx(0.1)


def test_stiffness_and_damping_scales_act_at_once():
    sim = simulation(path=_core.HandPath([0.1, 0.8], np.array([[0, 0, HEIGHT], [0, 0, -0.006]])))
    run(sim, 1.5)
    sim.controls = controls(stiffness_scale=0.5)
    t = run(sim, 0.001)
    np.testing.assert_allclose(t["F_spring_W"], 200.0 * t["delta_x"], rtol=1e-3)


def test_tool_follows_the_scaled_motion_of_the_hand():
    sim = simulation(path=_core.HandPath([0.0], np.array([[0, 0, HEIGHT]])))
    run(sim, 0.2)
    sim.controls = controls(p_hand_offset_W=np.array([0.02, 0.0, 0.0]))
    ticks = run(sim, 2.0)
    assert ticks["p_WT"][-1][0] == pytest.approx(0.01, abs=5e-4)  # half of the hand's motion


def test_jaw_follows_the_gripper_of_the_hand():
    """From the gripper through encoder and mapping to the follower's jaw, within the speed limit of the jaw."""
    path = _core.HandPath([0.1, 1.0, 2.0], np.tile([0, 0, HEIGHT], (3, 1)), [0.0, 1.0, 0.0])
    ticks = run(simulation(path=path), 3.0)
    o = _core.MappingOptions()
    fraction = (ticks["gripper"] - o.gripper_min) / (o.gripper_max - o.gripper_min)
    assert fraction[1000] > 0.9
    expected = o.jaw_min + fraction * (o.jaw_max - o.jaw_min)
    np.testing.assert_allclose(ticks["jaw"][[1100, 2900]], expected[[1100, 2900]], atol=0.05)
    assert np.abs(np.diff(ticks["jaw"])).max() <= o.jaw_rate * 1e-3 * 1.5


def test_scenes_are_replaced_as_a_whole_during_a_run():
    sim = simulation(path=_core.HandPath([0.1, 0.8], np.array([[0, 0, HEIGHT], [0, 0, -0.006]])))
    assert run(sim, 1.5)["contacts"][-1] == 1
    sim.set_snapshot(_core.Snapshot([]))
    assert run(sim, 0.001)["contacts"][-1] == 0
    for _ in range(50):
        sim.set_snapshot(floor())
        ticks = run(sim, 0.002)
    assert np.isfinite(as_rows(ticks)).all()


@pytest.mark.parametrize("rate", [250.0, 500.0, 4000.0])
def test_force_is_independent_of_the_rates(rate):
    path = _core.HandPath([0.1, 0.8], np.array([[0, 0, HEIGHT], [0, 0, -0.006]]))
    ticks = run(simulation(path=path, rate=rate), 2.5, rate)
    np.testing.assert_allclose(np.diff(ticks["t"]), 1 / rate, rtol=1e-6)
    held = np.linalg.norm(ticks["F_T_W"][-50:], axis=1)
    reference = np.linalg.norm(run(simulation(path=path), 2.5)["F_T_W"][-50:], axis=1)
    assert held.mean() == pytest.approx(reference.mean(), rel=0.1)


def test_wrong_gravity_model_of_the_controller_loads_the_hand():
    arm = Arm.mtm("right")
    args = (Arm.psm("lnd"), _core.Snapshot([]), _core.HandPath([0.0], np.array([[0, 0, HEIGHT]])))
    right = as_ticks(_core.Simulation(options(), arm, arm, *args).run(1500))[-1]
    wrong = as_ticks(_core.Simulation(options(), arm, arm.with_scaled_masses(np.full(7, 0.5)), *args).run(1500))[-1]
    masses_off = right["tau_gravity"] - 0.5 * arm.gravity(right["q"])  # the counterbalance spring of the model is right
    np.testing.assert_allclose(wrong["tau_gravity"], masses_off, atol=5e-3)
    assert np.linalg.norm(wrong["F_cell_L"]) > np.linalg.norm(right["F_cell_L"]) + 0.1


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"q_leader0": np.zeros(3)}, "q_leader0 has 3 joints"),
        ({"q_follower0": np.array([0, 0, 0.5, 0, 0, 0])}, "outside its limits"),
        ({"plant_rate": 10.0}, "plant_rate"),
        ({"loop_delay": -1.0}, "loop_delay"),
        ({"method": "guess"}, "proxy"),
        ({"tremor": 1.0}, "tremor"),
    ],
)
def test_invalid_options_are_reported(changes, message):
    with pytest.raises((ValueError, RuntimeError), match=message):
        simulation(**changes)


@pytest.mark.parametrize(
    ("times", "positions", "message"),
    [
        ([0.0, 0.0], np.zeros((2, 3)), "way point 1"),
        ([0.0], np.array([[0, np.nan, 0]]), "not finite"),
        ([0.0, 1.0], np.zeros((1, 3)), "2 times, 1 positions"),
    ],
)
def test_invalid_hand_paths_are_reported(times, positions, message):
    with pytest.raises(ValueError, match=message):
        _core.HandPath(times, positions)


def test_minimum_jerk_path_matches_finite_differences():
    path = _core.HandPath([0.0, 1.0, 3.0], np.array([[0, 0, 0], [0.1, 0, 0], [0.1, 0.2, 0]]), [0.0, 1.0, 0.5])
    t = np.linspace(-0.5, 3.5, 4001)
    p = np.array([path.at(x)[0] for x in t])
    v = np.array([path.at(x)[1] for x in t])
    np.testing.assert_allclose(np.gradient(p, t, axis=0), v, atol=1e-4)
    np.testing.assert_allclose(path.at(0.5)[0], [0.05, 0, 0], atol=1e-15)
    assert path.at(0.5)[1][0] == pytest.approx(1.875 * 0.1)  # peak speed of a minimum-jerk motion
    assert path.at(9.0)[2] == 0.5


def test_waypoints_of_one_motion_are_passed_at_its_speed():
    t = np.arange(0.0, 4.0, 0.5)
    line = np.outer(t, [0.03, -0.02, 0.01])
    path = _core.HandPath(t.tolist(), line)
    for x in np.linspace(0.5, 3.0, 101):  # from the first to the last but one waypoint
        np.testing.assert_allclose(path.at(x)[1], [0.03, -0.02, 0.01], atol=1e-12)


@pytest.mark.parametrize("then", [[0.0, 0.1, 0.0], [0.1, 0.1, 0.0], [-0.05, 0.0, 0.0], [0.1, 0.0, 0.0]])
def test_hand_rests_at_turns_and_at_repeated_waypoints(then):
    path = _core.HandPath([1.0, 2.0, 3.0], np.array([[0, 0, 0], [0.1, 0, 0], then]))
    np.testing.assert_array_equal(path.at(2.0)[1], 0.0)


@given(st.integers(0, 10_000))
def test_hand_never_moves_backwards_and_its_path_is_independent_of_the_frame(seed):
    rng = np.random.default_rng(seed)
    points, times = rng.normal(size=(6, 3)), np.cumsum(rng.uniform(0.1, 2.0, 6))
    R, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    path, turned = _core.HandPath(times.tolist(), points), _core.HandPath(times.tolist(), points @ R.T)
    for i in range(5):
        for t in np.linspace(times[i], times[i + 1], 23):
            p, v, _ = path.at(t)
            assert v @ (points[i + 1] - points[i]) >= -1e-12
            np.testing.assert_allclose(turned.at(t)[0], R @ p, atol=1e-12)


def test_samples_of_a_motion_are_passed_without_a_rest():
    t = np.arange(0, 2, 0.01)
    circle = 0.02 * np.column_stack([np.cos(t), np.sin(t), 0 * t])
    path = _core.HandPath(t.tolist(), circle)
    for x in np.linspace(0.1, 1.9, 500):
        p, v, _ = path.at(x)
        np.testing.assert_allclose(p, 0.02 * np.array([np.cos(x), np.sin(x), 0]), atol=2e-7)
        np.testing.assert_allclose(v, 0.02 * np.array([-np.sin(x), np.cos(x), 0]), atol=1.5e-4)

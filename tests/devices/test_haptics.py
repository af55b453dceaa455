"""palpate.Haptics against closed forms, against a session, and under bad input at every rate."""

import gc
import threading
import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import palpate
from palpate.base.errors import DeviceError, PalpateError
from palpate.record.reader import Record
from palpate.record.ticks import STATUS
from palpate.scene.guidance import Fixture, Sphere

K, RADIUS, CAP, RATE_CAP = 400.0, 0.002, 3.0, 50.0
CLOSED_FORM = {"passivity": "off"}  # the force is K times depth; with the observer it may be less


def scene(*objects, **changes):
    """The tool starts 10 mm above contact with the surface z = 0."""
    start = {"t": 0.0, "xyz": [0.0, 0.0, 0.01 + RADIUS]}
    return palpate.Scene.model_validate(
        {
            "objects": [{"name": "one", "stiffness": K, "damping": 0.0, **o} for o in objects or ({"plane": {}},)],
            "contact": {"radius": RADIUS},
            "mapping": {"scale": 1.0},
            "operator": {"path": [start, {**start, "t": 1.0}]},
            "stability": CLOSED_FORM,
            **changes,
        }
    )


def pose(x=0.0, y=0.0, z=0.0):
    X = np.eye(4)
    X[:3, 3] = x, y, z
    return X


def press(haptics, depth, rate=1000.0, speed=0.05, t=0.0, rest=0.1):
    """Move down from the start to `depth` [m] below contact, then rest; wrenches (n, 6) and the last time."""
    n = int((0.01 + depth) / speed * rate)
    heights = np.concatenate([-np.linspace(0.0, 0.01 + depth, n), np.full(int(rest * rate), -0.01 - depth)])
    felt = []
    for z in heights:
        t += 1.0 / rate
        felt.append(haptics.step(t, pose(z=z)))
    return np.array(felt), t


@pytest.mark.parametrize("reader", [False, True])
def test_an_object_that_nobody_closes_ends_its_threads_and_completes_its_record(tmp_path, reader, request):
    """Also where the thread that reads its ticks collects it, in the middle of reading."""
    before = set(threading.enumerate())
    haptics = palpate.Haptics(scene(), record=tmp_path)
    felt, _ = press(haptics, 0.002)
    if reader:
        haptics.itself = haptics  # only a collection ends this circle
        gc.disable()
        request.addfinalizer(gc.enable)
        session, take = haptics.session, haptics.session._take
        session._take = lambda *args, **options: (take(*args, **options), gc.collect())
        haptics.step(10.0, pose())
    steps = len(felt) + reader
    del haptics
    if not reader:
        gc.collect()
    end = time.monotonic() + 10.0
    while not set(threading.enumerate()) <= before:
        assert time.monotonic() < end, f"still running: {set(threading.enumerate()) - before}"
        time.sleep(0.01)
    (path,) = tmp_path.rglob("*.mcap")
    assert len(Record.open(path)) == steps


def test_time_without_a_measurement_passes_once():
    """A failure lets a period pass, which the next measurement's time contains: a run showed up to twice its time."""
    with palpate.Haptics(scene()) as haptics:
        loop = haptics.session.plant.loop
        cycle, wrench = loop.cycle, loop.wrench
        shown = []
        for k in range(1000):
            if k % 200 >= 100 and k % 7:
                cycle.report_failure(wrench)
            else:
                haptics.step(0.001 * k, pose())
            shown.append(float(haptics.session.latest()["t"]))
        assert haptics.session.latest()["t"] == pytest.approx(0.999, abs=0.008)
        assert np.diff(shown).min() > 0.0


@pytest.mark.parametrize("rate", [500.0, 1000.0, 4000.0])
def test_force_of_a_plane_is_stiffness_times_depth_up_to_the_cap(rate):
    with palpate.Haptics(scene(), rate=rate) as haptics:
        felt, t = press(haptics, 0.004, rate)
        assert felt[-1] == pytest.approx([0, 0, K * 0.004, 0, 0, 0], abs=1e-5)
        assert haptics.status == "ok"
        assert haptics.why() == "ok"
        assert np.abs(np.diff(felt[:, 2])).max() * rate <= RATE_CAP * (1 + 1e-9)
        for i in range(int(0.15 * rate)):
            t += 1.0 / rate
            felt = haptics.step(t, pose(z=-0.014 - min(0.05 * i / rate, 0.006)))
        assert np.linalg.norm(felt[:3]) == pytest.approx(CAP)
        assert "force_capped" in haptics.status


def test_force_of_a_sphere_points_along_its_normal():
    ball = {"sphere": {"radius": 0.02}, "pose": {"xyz": [0, 0, -0.02]}}
    with palpate.Haptics(scene(ball)) as haptics:
        for i in range(600):
            s = min(1.0, i / 400)
            felt = haptics.step(0.001 * i, pose(0.006 * s, 0.0, -0.014 * s))
    p = np.array([0.006, 0.0, 0.012 - 0.014 + 0.02])  # of the tool from the centre of the ball
    distance = np.linalg.norm(p)
    assert felt[:3] == pytest.approx(K * (0.022 - distance) * p / distance, abs=2e-3)


def test_force_is_in_the_axes_of_the_device():
    turned = {"leader": {"base": {"xyz": [0, 0, 0], "rpy_deg": [90, 0, 0]}}}  # y of the device is z of the world
    with palpate.Haptics(scene(arms=turned)) as haptics:
        for i in range(500):
            felt = haptics.step(0.001 * i, pose(y=-0.012 * min(1.0, i / 300)))
    assert felt[:3] == pytest.approx([0.0, K * 0.002, 0.0], abs=1e-5)


def test_same_motion_as_a_session_gives_the_same_force():
    """A hand as stiff as the core allows leads the simulated leader; its poses are then stepped through Haptics."""
    path = [{"t": 0.0, "xyz": [0, 0, 0.006]}, {"t": 0.4, "xyz": [0, 0, -0.002]}, {"t": 0.6, "xyz": [0.01, 0, -0.002]}]
    given_scene = scene(
        operator={"path": path, "stiffness": 1500.0, "damping": 30.0, "mass": 0.2},
        arms={"follower": {"bandwidth": 0.0}, "leader": {"quantised": False}},
        mapping={"scale": 1.0, "align_rate": 0.0},
    )
    session = palpate.Session(given_scene)
    ticks = [session.step().tick for _ in range(900)]
    X_WL = session.rig.arms.X_WL
    leader = given_scene.arms.leader.model_copy(update={"base": None})
    arms = given_scene.arms.model_copy(update={"leader": leader})
    haptics = palpate.Haptics(given_scene.model_copy(update={"arms": arms}))
    arm, felt = session.rig.arms.leader, []
    for tick in ticks:
        X_W = X_WL @ arm.fk(np.asarray(tick["q"])[: arm.n])  # Haptics' device has the axes of the world
        felt.append(haptics.step(float(tick["t"]) + 1.0, X_W, gripper=float(tick["gripper"]))[:3])
    wanted = np.array([X_WL[:3, :3] @ tick["F_H_L"] for tick in ticks])
    assert np.linalg.norm(wanted, axis=1).max() > 0.4
    error = np.linalg.norm(np.array(felt)[1:] - wanted[:-1], axis=1)  # the tool of Haptics follows one step later
    best = min(np.abs(np.array(felt)[lag:] - wanted[: len(wanted) - lag]).max() for lag in range(4))
    assert best < 0.02, error.max()
    haptics.close()


@pytest.fixture
def pressing():
    """Haptics pressing 4 mm deep: 1.6 N."""
    with palpate.Haptics(scene()) as haptics:
        felt, t = press(haptics, 0.004)
        assert felt[-1, 2] == pytest.approx(1.6, abs=1e-4)
        yield haptics, t


BAD = {
    "not_finite": lambda X: np.where(np.arange(16).reshape(4, 4) == 5, np.nan, X),
    "not_rigid": lambda X: X * np.array([1.1, 1.1, 1.1, 1.0])[:, None],
    "left_handed": lambda X: X @ np.diag([-1.0, 1, 1, 1]),
}


@pytest.mark.parametrize(("name", "broken"), BAD.items())
def test_invalid_pose_gives_zero_force_at_once_by_name_and_mend(pressing, name, broken):
    haptics, t = pressing
    X = pose(z=-0.014)
    assert not haptics.step(t + 0.001, broken(X)).any()
    assert haptics.status.startswith(name)
    assert "mend: " in haptics.why()
    back = np.array([haptics.step(t + 0.001 * (2 + i), X)[:3] for i in range(400)])
    assert not back[:90].any(), "no force until all is well for 0.1 s"
    assert haptics.status == "ok"
    assert np.abs(np.diff(back[:, 2])).max() <= RATE_CAP * 1e-3 * (1 + 1e-9)


@pytest.mark.parametrize("wrong", [{"V": [np.nan] * 6}, {"gripper": np.inf}, {"V": [1e9, 0, 0, 0, 0, 0]}])
def test_invalid_velocity_or_gripper_gives_zero_force(pressing, wrong):
    haptics, t = pressing
    assert not haptics.step(t + 0.001, pose(z=-0.014), **wrong).any()
    assert haptics.status.startswith("not_finite")


def test_time_that_does_not_increase_ramps_to_zero_within_20_ms(pressing):
    haptics, t = pressing
    felt = [haptics.step(t - 0.5, pose(z=-0.014))]
    assert haptics.status.startswith("time_not_increasing")
    felt += [haptics.step(t - 0.5 + 0.001 * i, pose(z=-0.014)) for i in range(1, 21)]
    assert not felt[-1].any()
    for _i in range(20):  # a clock that stands still
        last = haptics.step(t, pose(z=-0.014))
    assert not last.any()
    assert haptics.status.startswith("time_not_increasing")


def test_zero_force_in_the_first_step_after_a_gap(pressing):
    haptics, t = pressing
    assert not haptics.step(t + 0.021, pose(z=-0.014)).any()
    assert haptics.status.startswith("gap")
    assert "20 ms" in haptics.why()


def test_jump_of_the_pose_removes_the_force(pressing):
    haptics, t = pressing
    felt = [haptics.step(t + 0.001 * i, pose(x=0.05, z=-0.014)) for i in range(1, 21)]
    assert not felt[-1].any()


def test_loop_faster_than_its_rate_is_refused_with_the_mend():
    with palpate.Haptics(scene()) as haptics:
        for i in range(2000):
            felt = haptics.step(i / 4000, pose(z=max(-0.014, -0.04 * i / 1000)))
        assert not felt.any()
        assert haptics.status.startswith("too_often")
        assert "rate=4000" in haptics.why()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((np.eye(3),), r"X must have shape \(4, 4\)\. Got: \(3, 3\)"),
        (("abc",), "X must be an array of numbers"),
        ((np.eye(4), np.zeros(3)), r"V must have shape \(6,\)\. Got: \(3,\)"),
        ((np.eye(4), None, "open"), "must be numbers"),
    ],
)
def test_wrong_shape_or_type_is_an_error_and_sets_the_force_to_zero(pressing, arguments, words):
    haptics, t = pressing
    with pytest.raises(DeviceError, match=words):
        haptics.step(t + 0.001, *arguments)
    assert not np.asarray(haptics.session.latest()["F_H_L"]).any()


def test_clutch_button_lets_the_hand_move_without_the_tool(pressing):
    haptics, t = pressing
    for i in range(1, 201):
        felt = haptics.step(t + 0.001 * i, pose(x=1e-4 * i, z=-0.014), buttons=1)
    tip = np.asarray(haptics.session.latest()["p_WT"])
    assert not felt.any()
    assert tip[0] == pytest.approx(0.0, abs=1e-6)
    for i in range(201, 401):
        felt = haptics.step(t + 0.001 * i, pose(x=0.02, z=-0.014))
    assert felt[2] == pytest.approx(1.6, abs=1e-3)
    assert np.asarray(haptics.session.latest()["p_WT"])[0] == pytest.approx(0.0, abs=1e-6)


def test_controls_fixtures_and_closing(pressing):
    haptics, t = pressing
    controls = haptics.session.controls
    controls.stiffness_scale = 0.5
    haptics.session.controls = controls
    for i in range(1, 101):
        felt = haptics.step(t + 0.001 * i, pose(z=-0.014))
    assert felt[2] == pytest.approx(0.8, abs=1e-4)
    assert haptics.close().ticks == haptics.close().ticks > 0
    with pytest.raises(DeviceError, match="after close"):
        haptics.step(t + 1.0, np.eye(4))


def test_fixtures_pull_the_hand_and_can_be_set_live():
    ball = Fixture(Sphere(radius=0.01, at=(0.0, 0.0, 0.0)), role="forbid", law={"name": "spring", "stiffness": 300.0})
    with palpate.Haptics(scene()) as haptics:
        for i in range(400):
            felt = haptics.step(0.001 * i, pose(z=-0.004 * min(1.0, i / 200)))
        assert not felt.any()
        haptics.session.fixtures = [ball]
        for i in range(400, 1400):
            felt = haptics.step(0.001 * i, pose(z=-0.004))
        assert felt[2] == pytest.approx(300.0 * 0.002, rel=0.02)
        assert "guided" in haptics.status


def test_record_contains_the_run(tmp_path):
    with palpate.Haptics(scene(), record=tmp_path) as haptics:
        felt, t = press(haptics, 0.004)
        haptics.step(t + 0.001, np.full((4, 4), np.nan))
        summary = haptics.close()
    ticks = Record.open(summary.record).ticks
    assert len(ticks) == len(felt) + 1 == summary.ticks
    assert ticks["F_H_L"][:-1] == pytest.approx(felt[:, :3], abs=1e-9)
    assert ticks["status"][-1] & STATUS["not_finite"][0]
    assert any("not finite" in fault for fault in summary.faults)
    assert palpate.Scene.load(next(tmp_path.glob("*/scene.yaml"))).arms.leader.driver == "loop"


@pytest.mark.parametrize(
    ("arguments", "words"), [({"rate": 20.0}, "rate = 20"), ({"force_cap": 5.0}, "at most the scene's 3 N")]
)
def test_rate_and_cap_out_of_range_are_refused(arguments, words):
    with pytest.raises(PalpateError, match=words):
        palpate.Haptics(scene(), **arguments)


def test_lower_cap_holds():
    with palpate.Haptics(scene(), force_cap=0.5) as haptics:
        felt, _ = press(haptics, 0.006)
    assert np.linalg.norm(felt[:, :3], axis=1).max() == pytest.approx(0.5)


numbers = st.one_of(st.floats(-0.03, 0.03), st.sampled_from([np.nan, np.inf, -np.inf, 1e9, -1e308, 0.0]))
steps = st.lists(
    st.tuples(
        st.one_of(st.sampled_from([0.001, 0.002]), st.sampled_from([0.0, -1.0, np.nan, np.inf, 0.05, 1e12])),
        st.lists(numbers, min_size=3, max_size=3),
        st.one_of(st.just(0.0), st.floats(-4, 4), st.just(np.nan)),
        st.booleans(),
        st.one_of(st.just(0.0), st.just(np.nan), st.just(50.0)),
    ),
    min_size=1,
    max_size=40,
)


@pytest.fixture(scope="module")
def shared():
    with palpate.Haptics(scene()) as haptics:
        press(haptics, 0.004)
        yield haptics


@settings(max_examples=60, deadline=None, derandomize=True)
@given(given_steps=steps)
def test_any_input_gives_a_finite_force_below_the_cap_and_invalid_input_none(shared, given_steps):
    t, before = 100.0, None
    for dt, p, turn, mirrored, gripper in given_steps:
        t = t + dt if np.isfinite(t + dt) and abs(t + dt) < 1e15 else 100.0
        X = np.eye(4)
        if np.isfinite(turn):
            X[:3, :3] = Rotation.from_rotvec([0.0, turn, 0.0]).as_matrix()
        else:
            X[0, 0] = turn
        X[:3, 3] = p
        if mirrored:
            X[:3, 0] *= -1.0
        felt = shared.step(t if np.isfinite(dt) else dt, X, gripper=gripper)
        assert np.isfinite(felt).all()
        assert np.linalg.norm(felt[:3]) <= CAP * (1 + 1e-9)
        if mirrored or not np.isfinite([*p, turn, gripper]).all() or np.abs(p).max() > 100 or gripper > 10:
            assert not felt.any()
            assert shared.status != "ok"
        if before is not None:
            rise = np.linalg.norm(felt[:3]) - np.linalg.norm(before[:3])
            assert rise <= RATE_CAP * 0.0021
        before = felt

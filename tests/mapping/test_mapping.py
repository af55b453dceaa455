"""The mapping from hand to tool against the closed form of its law, and the continuity of the goal."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from palpate import _core

DT = 1e-3


def rotation(axis, angle):
    """Rodrigues' formula."""
    k = np.asarray(axis, float) / np.linalg.norm(axis)
    K = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def pose(p=(0, 0, 0), R=None):
    X = np.eye(4)
    X[:3, :3] = np.eye(3) if R is None else R
    X[:3, 3] = p
    return X


def angle(R):
    return np.arccos(np.clip((np.trace(R) - 1) / 2, -1, 1))


def make(R_WL=None, **options):
    o = _core.MappingOptions()
    for name, value in options.items():
        setattr(o, name, value)
    return _core.Mapping(o, np.eye(3) if R_WL is None else R_WL, DT)


def step(m, X_WH, X_WT, v=(0, 0, 0), **kwargs):
    return m.step(X_WH, np.array(v, float), kwargs.pop("gripper", 0.0), X_WT, **kwargs)


def test_position_is_relative_and_scaled():
    m = make(scale=0.3)
    hand0, tool0 = np.array([0.1, 0.2, 0.3]), np.array([-0.4, 0.5, 0.0])
    goal, *_ = step(m, pose(hand0), pose(tool0))
    np.testing.assert_allclose(goal[:3, 3], tool0, atol=1e-15)
    motion = np.array([0.02, -0.03, 0.01])
    goal, *_ = step(m, pose(hand0 + motion), pose(tool0))
    np.testing.assert_allclose(goal[:3, 3], tool0 + 0.3 * motion, atol=1e-15)
    np.testing.assert_allclose(m.hand_position(goal[:3, 3]), hand0 + motion, atol=1e-15)


def test_engaging_starts_at_the_tool_and_aligns_within_the_align_rate():
    R_hand, R_tool = rotation([1, 2, 3], 0.4), rotation([-1, 0.5, 1], 1.1)
    m = make(align_rate=0.5)
    last = R_tool
    for _ in range(10_000):
        goal, *_ = step(m, pose(R=R_hand), pose(R=R_tool))
        assert angle(last.T @ goal[:3, :3]) <= 0.5 * DT + 1e-8
        last = goal[:3, :3]
    np.testing.assert_allclose(last, R_hand, atol=1e-9)  # the final orientation is that of the hand


def test_align_rate_zero_keeps_the_offset():
    R_tool = rotation([0, 1, 1], 0.7)
    m = make(align_rate=0.0)
    step(m, pose(), pose(R=R_tool))
    turn = rotation([0, 0, 1], 0.3)
    for _ in range(100):
        goal, *_ = step(m, pose(R=turn), pose(R=R_tool))
    np.testing.assert_allclose(goal[:3, :3], turn @ R_tool, atol=1e-12)


def test_clutch_holds_the_tool_and_resets_the_offset():
    m = make(scale=0.5)
    hand, tool = np.zeros(3), np.array([0.1, 0.0, 0.0])
    step(m, pose(hand), pose(tool))
    before, *_ = step(m, pose([0.02, 0, 0]), pose(tool))
    for x in np.linspace(0.02, 0.3, 50):  # a distant, rotated pose
        held, _, v, engaged = step(m, pose([x, 0, 0], rotation([0, 1, 0], x)), pose(tool), v=(1, 0, 0), clutch=True)
        np.testing.assert_array_equal(held, before)
        assert not engaged
        assert not v.any()
    released, _, _, engaged = step(m, pose([0.3, 0, 0], rotation([0, 1, 0], 0.3)), pose(tool))
    assert engaged
    np.testing.assert_allclose(released, before, atol=1e-12)
    moved, *_ = step(m, pose([0.31, 0, 0], rotation([0, 1, 0], 0.3)), pose(tool))
    np.testing.assert_allclose(moved[:3, 3] - before[:3, 3], [0.005, 0, 0], atol=1e-12)


def test_clutch_discards_an_unreachable_goal():
    m = make(scale=1.0)
    step(m, pose(), pose())
    step(m, pose([1, 0, 0]), pose([0.2, 0, 0]))
    held, *_ = step(m, pose([1, 0, 0]), pose([0.2, 0, 0]), clutch=True, reached=False)
    np.testing.assert_array_equal(held[:3, 3], [0.2, 0, 0])


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(st.booleans(), st.booleans()), min_size=5, max_size=60))
def test_pedals_never_make_the_goal_jump(pedals):
    """Per tick the goal moves at most as the scaled hand, and rotates at most as hand plus alignment."""
    m = make(scale=0.5, align_rate=0.5)
    rng = np.random.default_rng(7)
    p, R, last = np.zeros(3), np.eye(3), pose([0.1, 0.2, 0.3], rotation([1, 1, 0], 2.0))
    tool = last
    for following, clutch in pedals:
        dp, turn = rng.normal(0, 1e-3, 3), rng.normal(0, 2e-3, 3)
        p, R = p + dp, rotation(turn, np.linalg.norm(turn)) @ R
        goal, *_ = step(m, pose(p, R), tool, following=following, clutch=clutch)
        assert np.linalg.norm(goal[:3, 3] - last[:3, 3]) <= 0.5 * np.linalg.norm(dp) + 1e-12
        assert angle(last[:3, :3].T @ goal[:3, :3]) <= np.linalg.norm(turn) + 0.5 * DT + 1e-7
        last = tool = goal


def test_jaw_follows_the_gripper_linearly_within_its_rate():
    m = make(gripper_min=0.1, gripper_max=1.1, jaw_min=-0.2, jaw_max=0.8, jaw_rate=2.0)
    last = -0.2
    for _ in range(2000):
        _, jaw, *_ = step(m, pose(), pose(), gripper=0.6, jaw=-0.2)
        assert abs(jaw - last) <= 2.0 * DT + 1e-12
        last = jaw
    assert last == pytest.approx(0.3)
    for _ in range(2000):
        _, jaw, *_ = step(m, pose(), pose(), gripper=9.0)
    assert jaw == pytest.approx(0.8)


def test_forces_are_only_rotated_and_damping_uses_the_scaled_velocity():
    R_WL = rotation([1, -2, 0.5], 0.9)
    m = make(R_WL, scale=0.25, force_scale=2.0)
    F = np.array([1.0, -2.0, 0.5])
    np.testing.assert_allclose(m.force_on_hand(F), 2.0 * R_WL.T @ F, atol=1e-15)
    _, _, v, _ = step(m, pose(), pose(), v=(0.1, 0.2, -0.3))
    np.testing.assert_allclose(v, 0.25 * R_WL @ [0.1, 0.2, -0.3], atol=1e-16)


def test_stiffness_at_the_hand_is_scale_times_stiffness():
    """F = K s dx_hand, so the stiffness at the hand is s K."""
    m = make(scale=0.4)
    K = 500.0
    step(m, pose(), pose())
    goal, *_ = step(m, pose([0, 0, -0.01]), pose())
    force = m.force_on_hand(np.array([0, 0, -K * goal[2, 3]]))
    assert force[2] / 0.01 == pytest.approx(0.4 * K)


@pytest.mark.parametrize(
    ("name", "value"), [("scale", 0.0), ("scale", float("nan")), ("jaw_rate", 0.0), ("align_rate", -1.0)]
)
def test_invalid_options_are_reported(name, value):
    with pytest.raises(ValueError, match=f"mapping.{name}"):
        make(**{name: value})


def test_locked_rotation_keeps_the_attitude_and_unlocking_does_not_jump():
    m, R_tool = make(scale=0.5), rotation([0, 1, 1], 0.4)
    step(m, pose(), pose(R=R_tool))
    before, *_ = step(m, pose(), pose(R=R_tool), lock_rotation=True)
    for k in range(1, 30):
        goal, *_ = step(m, pose([1e-3 * k, 0, 0], rotation([1, 0, 0], 0.02 * k)), pose(), lock_rotation=True)
        np.testing.assert_array_equal(goal[:3, :3], before[:3, :3])
        np.testing.assert_allclose(goal[:3, 3], [5e-4 * k, 0, 0], atol=1e-12)
    after, *_ = step(m, pose([0.029, 0, 0], rotation([1, 0, 0], 0.58)), pose())
    np.testing.assert_allclose(after, goal, atol=1e-12)


def test_locked_translation_keeps_the_position_and_unlocking_does_not_jump():
    m = make(scale=0.5, align_rate=0.0)
    step(m, pose(), pose())
    for k in range(30):
        turn = rotation([0, 0, 1], 0.01 * k)
        goal, _, v, _ = step(m, pose([2e-3 * k, 0, 0], turn), pose(), v=(1, 0, 0), lock_translation=True)
        np.testing.assert_array_equal(goal[:3, 3], np.zeros(3))
        np.testing.assert_allclose(goal[:3, :3], turn, atol=1e-12)
        assert not np.any(v), "a tool that does not move is not damped"
    after, *_ = step(m, pose([0.058, 0, 0], turn), pose())
    np.testing.assert_allclose(after, goal, atol=1e-12)
    moved, *_ = step(m, pose([0.068, 0, 0], turn), pose())
    np.testing.assert_allclose(moved[:3, 3], [0.005, 0, 0], atol=1e-12)


def test_ratchet_never_opens_the_jaw_by_itself():
    """The hand arrives with the pinch open: the jaw waits until the pinch has closed to it, then follows."""
    m = make(ratchet=True)
    jaws = []
    for pinch in (*np.full(50, 0.9), *np.linspace(0.9, 0.1, 400), *np.linspace(0.1, 0.8, 700)):
        _, jaw, *_ = step(m, pose(), pose(), gripper=float(pinch), jaw=0.3)
        jaws.append(jaw)
    jaws = np.array(jaws)
    np.testing.assert_array_equal(jaws[:300], 0.3)  # the pinch is still above 0.3 rad
    assert jaws.max() <= 0.801
    assert jaws[449] == pytest.approx(0.1, abs=2e-3)
    assert jaws[-1] == pytest.approx(0.8, abs=2e-3)
    step(m, pose(), pose(), gripper=0.8, jaw=0.8, clutch=True)
    _, held, *_ = step(m, pose(), pose(), gripper=1.0, jaw=0.8)
    assert held == jaws[-1], "held again after the clutch"


def test_without_ratchet_the_jaw_opens():
    m = make()
    opened = [step(m, pose(), pose(), gripper=0.9, jaw=0.3)[1] for _ in range(100)]
    assert opened[-1] > opened[0]


@pytest.mark.parametrize("wrench", [{"F_T_W": np.array([0.0, 0.0, 1e-6])}, {"t_T_W": np.array([1e-9, 0.0, 0.0])}])
def test_a_tool_that_something_touches_does_not_turn_by_itself(wrench):
    R_tool, R_next = rotation([0, 1, 1], 0.7), rotation([1, 0, 0], 0.3)
    m = make(align_rate=0.5)
    for _ in range(100):
        goal, *_ = step(m, pose(), pose(R=R_tool), **wrench)
    np.testing.assert_allclose(goal[:3, :3], R_tool, atol=1e-12)
    goal, *_ = step(m, pose(R=R_next), pose(R=R_tool), **wrench)
    np.testing.assert_allclose(goal[:3, :3], R_next @ R_tool, atol=1e-12)  # it follows the hand
    for _ in range(100):
        free, *_ = step(m, pose(R=R_next), pose(R=R_tool))
    assert angle(goal[:3, :3].T @ free[:3, :3]) == pytest.approx(0.5 * 99 * DT, rel=0.03)  # and aligns when it is free

"""The tasks of scenes as environments: the scripts of the simulated operators do them through actions."""

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from palpate.base.errors import PalpateError, SceneError
from palpate.gym import Motion, PalpateEnv, PalpateVectorEnv
from palpate.session.tasks import look
from palpate.session.tasks.hand import OPEN, STEP, Hand
from palpate.session.tasks.scripts import script_of

pytest.importorskip("mujoco")

FAR = Motion(speed=0.2, reach=0.2)


class Scripted(Hand):
    """A hand of a script that moves by actions, without an error of sight."""

    def __init__(self, env, number):
        self._env, self.number, self.pinch, self.marking = env, number, OPEN, 0
        self.person = type("Steady", (), {"pace": 0.12})
        many = env.instruments
        self._start = many.starts.reshape(many.h, 3)[number]
        self._tick = lambda: many.ticks.reshape(-1)[number]
        self.p_WT = np.array(self._tick()["p_WT"])
        self.goal = self._start.copy()
        jaws = [c["to"] for c in many.world.rigs[number].arms.follower.capsules if str(c["link"]).startswith("jaw")]
        self._reach = max(float(np.linalg.norm(to)) for to in jaws)

    @property
    def _R_WT(self):
        from palpate.base.arrays.so3 import pose

        return pose(np.zeros(3), self._tick()["quat_WT"])[:3, :3]

    @property
    def force(self):
        return float(np.linalg.norm(self._tick()["F_H_L"]))

    @property
    def action(self):
        return np.r_[self.goal - self._start, np.zeros(3), self.pinch / OPEN]

    def update(self):
        self.p_WT = np.array(self._tick()["p_WT"])
        if self.marking:
            self.marking -= 1
            self.pinch = 0.0 if self.marking else OPEN


class Pedals:
    """The pedal coag as the closing of the pinch."""

    def __init__(self, hand):
        self._hand = hand

    def set(self, pedal, down, by):
        if down:
            self._hand.marking = 20  # steps: the pinch closes at 3 rad/s, and the script presses the pedal for one


def done_by_script(scene, seed=1, most=15000, **values):
    """Play an episode; returns its rewards, whether it succeeded, and the result of the judge."""
    env = PalpateEnv(scene=scene, action="pose", motion=FAR, substeps=round(1000 * STEP), **values)
    env.reset(seed=seed)
    task, many = env._one.task, env.instruments
    hands = [Scripted(env, k) for k in range(many.h)]
    script = script_of(many.world.scene.task, hands, task._judges[0], Pedals(hands[0]))
    rewards = []
    for _ in range(most):
        p_WT = many.ticks["p_WT"].reshape(-1, 3)
        script.step(look(float(many.times[0]), p_WT, many.engines[0], task._marks[0]))
        _, reward, done, cut, info = env.step(np.concatenate([hand.action for hand in hands]))
        rewards.append(reward)
        if done or cut:
            break
    result = task.results()[0]
    env.close()
    return np.array(rewards), info["is_success"], result


def test_a_script_does_a_task_by_actions():
    """Bodies are grasped by the pinch, led by the goal, and let go; the reward adds up to that of the whole task."""
    rewards, success, result = done_by_script("ring_on_wire")
    assert success
    assert result.success
    assert result.drops == 0
    assert rewards.sum() == pytest.approx(20.0)
    assert 10.0 < result.time_s < 40.0


@pytest.mark.long
@pytest.mark.parametrize("scene", ["tray_cubes", "needle_passing", "palpation_search", "peg_transfer"])
@pytest.mark.parametrize("seed", [1, 2])
def test_scripts_do_the_long_tasks_by_actions(scene, seed):
    _, success, result = done_by_script(scene, seed)
    assert success
    assert result.drops == 0


@pytest.mark.parametrize(("scene", "hands", "bodies"), [("peg_transfer", 2, 6), ("ring_on_wire", 1, 1)])
def test_spaces_hold_all_hands_and_bodies(scene, hands, bodies):
    env = gymnasium.make("palpate.gym:Palpate-v0", scene=scene, substeps=2)
    check_env(env.unwrapped)
    seen, _ = env.reset(seed=3)
    assert env.action_space.shape == (7 * hands,)
    assert seen["pose"].shape == (7 * hands,)
    assert seen["jaw"].shape == (hands,)
    assert seen["bodies"].shape == (7 * bodies,)
    world = env.unwrapped.instruments.world
    p_WB = np.array([body.pose.matrix()[:3, 3] for body in world.scene.bodies if body.free])
    np.testing.assert_allclose(seen["bodies"].reshape(bodies, 7)[:, :3], p_WB, atol=2e-3)
    assert np.linalg.norm(seen["goal"]) > 0.005
    env.close()


def test_worlds_are_alike_alone_and_among_others():
    """World i of a seed s is the single environment of the seed s + i, bit for bit, with bodies too."""
    actions = np.random.default_rng(4).uniform(-1.0, 1.0, (30, 3, 14)) * np.tile([0.05] * 3 + [0.5] * 3 + [1.0], 2)
    many = PalpateVectorEnv(3, "peg_transfer", workers=2, substeps=5)
    many.reset(seed=7)
    last = [many.step(action)[0] for action in actions][-1]
    many.close()
    one = PalpateEnv(scene="peg_transfer", substeps=5)
    one.reset(seed=9)
    alone = [one.step(action[2])[0] for action in actions][-1]
    one.close()
    for name, values in alone.items():
        np.testing.assert_array_equal(values, last[name][2])


def test_a_lump_is_hidden_by_the_seed_and_marked_by_the_pinch():
    env = PalpateEnv(scene="palpation_search", substeps=20)
    task, lumps = env._one.task, []
    for seed in (1, 2):
        seen, _ = env.reset(seed=seed)
        assert "bodies" not in seen
        lumps.append(task._judges[0].p_lump_W)
        np.testing.assert_array_equal(seen["goal"], 0.0)
    assert np.linalg.norm(lumps[0] - lumps[1]) > 1e-3
    opened, closed = np.r_[np.zeros(6), 1.0], np.zeros(7)
    rewards = [env.step(action)[1] for action in [opened] * 5 + [closed] * 20 + [opened] * 20 + [closed] * 20]
    assert len(task._marks[0]) == 2
    assert task.results()[0].errors["wrong_marks"] == 2.0
    assert sum(rewards) == pytest.approx(-2.0)
    env.close()


def test_what_an_environment_cannot_do_is_named():
    with pytest.raises(SceneError, match="torques of a follower's drives"):
        PalpateEnv(scene="bilateral")
    with pytest.raises(PalpateError, match="the pairs right, left"):
        PalpateEnv(scene="two_hands")
    with pytest.raises(PalpateError, match="no body that moves"):
        PalpateEnv(scene="palpation_search", observe=["bodies"])
    with pytest.raises(PalpateError, match="no section task"):
        PalpateEnv(scene="palpation", task="scene")


def test_the_picture_shows_the_bodies():
    """Some pixels change when the ring is taken away, and no others."""
    try:
        env = PalpateEnv(scene="ring_on_wire", picture=(96, 128))
    except PalpateError as error:
        pytest.skip(f"no picture: {error}")
    before = env.reset(seed=1)[0]["picture"].astype(int)
    engine = env.instruments.engines[0]
    engine.data.qpos[:3] += [0.0, 0.0, 0.5]
    engine.core_bodies.advance(0.002)
    after = env._one._observe()["picture"][0].astype(int)
    assert 0 < (before.min(axis=2) > 150).mean() < 0.9  # the table has the light colour that the scene gives it
    assert 5 < (np.abs(after - before).max(axis=2) > 30).sum() < 4000
    env.close()


SOFT = {"name": "block", "box": {"size": [0.06, 0.06, 0.03]}, "pose": {"xyz": [0, 0, -0.015]},
        "tissue": {"preset": "liver", "resolution": 0.012, "springs": 1e6}}  # fmt: skip
HANDS = {side: {"arms": {"follower": {"base": {"xyz": [x, 0, 0.15], "rpy_deg": [0, 0, 180]}}},
                "operator": {"path": [{"t": 0, "xyz": [x, 0, 0.01]}]}}
         for side, x in (("left", -0.02), ("right", 0.02))}  # fmt: skip


class Still:
    """A task without a reward."""

    def begin(self, n, dt, world):
        self.goals = np.zeros((n, 3))

    def reset(self, i, rig, rng):
        return None

    def evaluate(self, ticks, felt):
        return np.zeros(len(ticks)), np.zeros(len(ticks), dtype=bool)


@pytest.mark.parametrize("scene", [
    {"objects": [SOFT], "operator": {"path": [{"t": 0, "xyz": [0, 0, 0.01]}]}}, {"objects": [SOFT], "pairs": HANDS},
], ids=["one hand", "two hands"])  # fmt: skip
def test_soft_bodies_of_worlds_are_their_own(scene):
    """A hand that presses a soft body in one world is not felt in another, nor after a reset."""
    many = PalpateVectorEnv(2, scene, Still(), action="pose", substeps=10, workers=2)
    size = 7 if "pairs" in scene else 6
    still = np.zeros((2, many.action_space.shape[1]))
    deep = still.copy()
    deep[0, 2::size], deep[1, 2] = -0.014, -0.014  # in world 0 all hands, in world 1 the first
    alone = PalpateEnv(scene=scene, task=Still(), action="pose", substeps=10)
    for _ in range(2):
        many.reset(seed=1)
        alone.reset(seed=2)
        for _ in range(40):
            seen = many.step(deep)[0]
            one = alone.step(deep[1])[0]
        assert np.linalg.norm(seen["force"][0, :3]) > 0.05
        np.testing.assert_array_equal(seen["force"][1], one["force"])
    many.close()
    alone.close()


def test_an_object_that_hands_carry_is_refused():
    rod = {"name": "rod", "radius": 0.002, "length": 0.03, "pose": {"xyz": [0, 0, 0.05]}}
    with pytest.raises(SceneError, match="'rod' is not carried"):
        PalpateEnv(scene={"objects": [SOFT], "pairs": HANDS, "graspable": rod}, task=Still())

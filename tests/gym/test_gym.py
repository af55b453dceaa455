"""Environments: Gymnasium's own check, closed forms of force and motion, and equality of single and vectorised ones."""

import sys
import warnings

import numpy as np
import pytest

from palpate.base.errors import MissingExtraError, PalpateError

gymnasium = pytest.importorskip("gymnasium", reason="gymnasium (extra learning) is not installed")
from gymnasium.utils.env_checker import check_env  # noqa: E402

from palpate import _core  # noqa: E402
from palpate.base.arrays import rigid  # noqa: E402
from palpate.gym import Motion, PalpateEnv, PalpateVectorEnv, Press  # noqa: E402
from palpate.gym.world import World, cycle_at  # noqa: E402
from palpate.record.ticks import TICK_DOUBLES, as_ticks  # noqa: E402
from palpate.scene.overrides import override  # noqa: E402
from palpate.scene.scene import Scene  # noqa: E402

K = 400.0
FLOOR = {
    "objects": [{"name": "floor", "plane": {"size": 0.3}, "stiffness": K, "damping": 0.0,
                 "friction": 0.0}],
    "operator": {"palpate": {"at": [0, 0, 0], "force": 1.0, "hover": 0.01}},
}  # fmt: skip


def made(**more):
    return PalpateEnv(**{"scene": FLOOR, **more})


@pytest.mark.parametrize(
    "more",
    [{}, {"action": "pose"}, {"observe": ("force",), "substeps": 5}, {"vary": {"objects.0.stiffness": (200, 600)}}],
)
def test_gymnasium_finds_no_fault(more):
    env = gymnasium.make("palpate.gym:Palpate-v0", scene=FLOOR, duration=0.2, **more)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        check_env(env.unwrapped)
    assert [str(one.message) for one in told] == []


def test_force_is_that_of_the_spring():
    """Pressed slowly into a plane, the force is stiffness times penetration; the penetration is that of the tip."""
    env = made(action="pose", duration=10.0)
    env.reset(seed=0)
    start = env.instruments.starts[0, 2]
    radius = env.instruments.rigs[0].scene.contact.radius
    for depth in (0.001, 0.003):
        for _ in range(100):
            seen, *_ = env.step([0, 0, radius - depth - start, 0, 0, 0])
        np.testing.assert_allclose(seen["force"][:3], [0.0, 0.0, K * depth], atol=2e-3 * K * depth)
        assert seen["contact"][0] == pytest.approx(depth, rel=2e-3)
        assert seen["contact"][1] == 1
        np.testing.assert_allclose(seen["contact"][2:], [0.0, 0.0, 1.0], atol=1e-6)
        assert seen["force"][6] == pytest.approx(K * depth, rel=0.01)


def test_twist_moves_and_turns_as_asked():
    from scipy.spatial.transform import Rotation

    env = made(duration=10.0)
    before, _ = env.reset(seed=0)
    for _ in range(50):
        env.step([0.02, -0.01, 0.015, 0.0, 0.0, 0.3])
    for _ in range(20):
        after, *_ = env.step(np.zeros(6))
    np.testing.assert_allclose(after["pose"][:3] - before["pose"][:3], [0.02, -0.01, 0.015], atol=2e-4)
    turned = (
        Rotation.from_quat(np.roll(after["pose"][3:], -1)) * Rotation.from_quat(np.roll(before["pose"][3:], -1)).inv()
    )
    np.testing.assert_allclose(turned.as_rotvec(), [0.0, 0.0, 0.3], atol=3e-3)


def test_limits_of_motion_and_force_hold_whatever_the_action():
    env = made(duration=10.0, motion=Motion(speed=0.05, reach=0.03))
    env.reset(seed=1)
    start = env.instruments.starts[0].copy()
    cap = env.instruments.rigs[0].scene.stability.force_cap
    for _ in range(100):
        seen, *_ = env.step([1e6, -1e6, -1e6, 1e6, 0.0, 1e6])
        assert np.isfinite(seen["force"]).all()
        assert seen["force"][6] <= cap + 1e-6
    assert np.abs(seen["pose"][:3] - start).max() <= 0.031
    np.testing.assert_allclose(np.abs(env.instruments.goals[0, :3]), 0.03)


def test_vectorised_equals_single_bit_for_bit_for_any_number_of_threads():
    n, vary = 5, {"objects.0.stiffness": (200.0, 800.0)}
    actions = np.random.default_rng(0).uniform(-0.05, 0.05, (30, n, 6)) - [0, 0, 0.03, 0, 0, 0]
    runs = []
    for workers in (1, 3):
        many = PalpateVectorEnv(n, FLOOR, duration=0.4, workers=workers, vary=vary)
        many.reset(seed=7)
        runs.append([many.step(one) for one in actions])
        many.close()
    for (seen, reward, *_), (other, again, *_) in zip(*runs, strict=True):
        np.testing.assert_array_equal(reward, again)
        for name, values in seen.items():
            np.testing.assert_array_equal(values, other[name])
    env = made(duration=0.4, vary=vary)
    env.reset(seed=7 + 3)
    for one, (seen, reward, _, truncated, _) in zip(actions, runs[0], strict=True):
        mine, own, _, cut, _ = env.step(one[3])
        assert (own, cut) == (reward[3], truncated[3])
        np.testing.assert_array_equal(mine["force"], seen["force"][3])


def test_observations_are_fresh_arrays():
    many = PalpateVectorEnv(2, FLOOR)
    first, _ = many.reset(seed=0)
    kept = {name: values.copy() for name, values in first.items()}
    for _ in range(3):
        many.step(np.full((2, 6), 0.05))
    for name, values in first.items():
        np.testing.assert_array_equal(values, kept[name])


def test_scripted_hand_presses_and_succeeds():
    """A controller by force reaches the place and holds the force: the task can be done, and says so."""
    done = 0
    for seed in range(3):
        env = made(duration=6.0, task=Press(force=1.0))
        seen, _ = env.reset(seed=seed)
        for _ in range(300):
            push = 0.02 * (1.0 - seen["force"][2]) if np.linalg.norm(seen["goal"][:2]) < 0.003 else 0.0
            lateral = np.clip(3.0 * seen["goal"][:2], -0.05, 0.05)
            seen, reward, success, cut, info = env.step([*lateral, -push, 0, 0, 0])
            if success or cut:
                break
        done += success
        assert info["is_success"] == success
        assert not success or reward > 5.0
    assert done == 3


def test_nodule_is_found_where_it_is():
    env = PalpateEnv(scene="nodule", task="find", duration=8.0)
    seen, _ = env.reset(seed=2)
    centre = env._one.task._centres[0]
    assert not seen["goal"].any()
    for _ in range(400):
        towards = centre[:2] - seen["pose"][:2]
        seen, _, success, cut, _ = env.step(
            [*np.clip(3 * towards, -0.02, 0.02), 0.02 * (seen["force"][2] - 0.8), 0, 0, 0]
        )
        if success or cut:
            break
    assert success
    assert np.linalg.norm(towards) < 0.006


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"task": "prod"}, "there is no task 'prod'"),
        ({"observe": ("sight",)}, "sight to observe"),
        ({"substeps": 0}, "substeps = 0"),
        ({"task": "find"}, "no region to find"),
        ({"vary": {"objects.0.stiffness": (600, 200)}}, "two rising numbers"),
        ({"vary": {"objects.0.stiffness": (600, np.inf)}}, "two rising numbers"),
        ({"duration": np.nan}, "duration = nan"),
        ({"duration": np.inf}, "duration = inf"),
        ({"workers": 0}, "workers = 0"),
    ],
)
def test_mistakes_are_named(given, words):
    with pytest.raises(PalpateError, match=words):
        made(**given)


@pytest.mark.parametrize("bad", [{"speed": -1.0}, {"reach": np.nan}, {"tilt": np.inf}])
def test_limits_of_a_motion_and_a_force_are_positive(bad):
    with pytest.raises(ValueError, match="must be a positive number"):
        Motion(**bad)
    with pytest.raises(ValueError, match="force must be a positive number"):
        Press(force=0.0)


def test_actions_and_seeds_of_several_are_one_for_each():
    many = PalpateVectorEnv(3, FLOOR, workers=1)
    first, _ = many.reset(seed=np.int64(4))
    again, _ = many.reset(seed=[4, 5, 6])
    np.testing.assert_array_equal(first["goal"], again["goal"])
    for seeds in ([4, 5], [4, 5, 6, 7]):
        with pytest.raises(ValueError, match=f"{len(seeds)} seeds for 3"):
            many.reset(seed=seeds)
    for shape in ((6,), (1, 6), (3, 1)):
        with pytest.raises(ValueError, match=r"actions are \(n, 6\)"):
            many.step(np.zeros(shape))


def test_a_drawn_material_needs_no_new_arms_and_gives_the_same_ticks():
    """A reset that draws materials only reuses the rig: its ticks are those of a scene that was set up anew."""
    vary = {
        "objects.0.stiffness": (200, 800),
        "objects.0.friction": (0.1, 0.5),
        "objects.0.regions.0.stiffness": (900, 900),
    }
    scene = {
        **FLOOR,
        "objects": [FLOOR["objects"][0] | {"regions": [{"at": [0, 0, 0], "radius": 0.01, "stiffness": 900}]}],
    }
    world = World(scene, vary)
    (drawn,) = world.drawn(np.random.default_rng(3))
    assert drawn.arms is world.plain.arms
    material = drawn.scene.objects[0]
    values = {"objects.0.stiffness": material.stiffness, "objects.0.friction": material.friction}
    anew = World(override(Scene.of(scene), values), {}).plain
    to, rows, felt = (
        np.array([[0.01, 0, -0.02, 0, 0.1, 0, 0]]),
        [np.zeros((1, TICK_DOUBLES)) for _ in range(2)],
        np.zeros(1),
    )
    for rig, row in zip((drawn, anew), rows, strict=True):
        cycle, _ = cycle_at(rig)
        _core.glide_together([cycle], [], np.zeros(1), 1e-3, 400, np.zeros((1, 7)), to, row, felt)
    for name in ("F_T_W", "F_H_L", "p_WT", "q_follower", "depth"):
        np.testing.assert_array_equal(as_ticks(rows[0])[name], as_ticks(rows[1])[name])
    assert as_ticks(rows[0])["F_T_W"][0, 2] > 1.0
    assert (
        World(scene, {"operator.palpate.force": (1.0, 2.0)}).drawn(np.random.default_rng(0))[0].arms
        is not world.plain.arms
    )


def test_glide_is_the_straight_path_of_single_steps():
    """Ticks and largest force are those of poses given one by one, bit for bit of the same exponential."""
    world, n = World(FLOOR, {}), 300
    end = np.array([0.004, 0.0, -0.02, 0.1, -0.2, 0.3, 0.0])
    cycle, _ = cycle_at(world.plain)
    row, felt = np.zeros((1, TICK_DOUBLES)), np.zeros(1)
    _core.glide_together([cycle], [], np.zeros(1), 1e-3, n, np.zeros((1, 7)), end[None], row, felt)
    other, _ = cycle_at(world.plain)
    at = np.linspace(0.0, 1.0, n + 1)[1:, None] * end
    F = np.zeros((n, 6))
    other.replay(1e-3 * np.arange(1, n + 1), rigid.rigid(rigid.exp(at[:, 3:6]), at[:, :3]), F)
    assert felt[0] == pytest.approx(np.linalg.norm(F[:, :3], axis=1).max(), rel=1e-9)
    assert felt[0] > 1.0
    for name in ("p_WT", "F_T_W", "F_H_L"):
        np.testing.assert_allclose(
            as_ticks(row)[name][0], as_ticks(other.latest()[None])[name][0], rtol=1e-7, atol=1e-9
        )
    for t, rows, words in ((np.zeros(2), row, "equally many"), (np.zeros(1), np.zeros((2, TICK_DOUBLES)), "one row")):
        with pytest.raises(ValueError, match=words):
            _core.glide_together([cycle], [], t, 1e-3, n, np.zeros((1, 7)), end[None], rows, felt)


def test_a_step_before_the_first_reset_is_named():
    for env, action in ((made(), np.zeros(6)), (PalpateVectorEnv(3, FLOOR, workers=2), np.zeros((3, 6)))):
        with pytest.raises(gymnasium.error.ResetNeeded, match="call reset"):
            env.step(action)
        env.reset(seed=1)
        env.step(action)
        env.close()


def test_task_lies_in_the_scene_whose_values_were_drawn():
    """A region that is drawn elsewhere is found where it is drawn."""
    env = PalpateEnv(scene="nodule", task="find", vary={"objects.0.regions.0.at.0": (0.0, 0.01)})
    for seed in (1, 2):
        env.reset(seed=seed)
        region = env.instruments.rigs[0].scene.objects[0].regions[0]
        assert 0.0 <= region.at[0] <= 0.01
        surface = env.instruments.rigs[0].surfaces[0]
        place = surface.X_WO[:3, :3] @ region.at + surface.X_WO[:3, 3]
        np.testing.assert_allclose(env._one.task._centres[0], place)


def test_without_gymnasium_the_extra_is_named(monkeypatch):
    for name in [name for name in sys.modules if name.startswith("palpate.gym")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "gymnasium", None)
    with pytest.raises(MissingExtraError, match="learning"):
        import palpate.gym  # noqa: F401


@pytest.mark.parametrize("action", [[np.nan] * 6, [0.0] * 5, 0.0])
def test_an_action_that_is_no_motion_is_refused_and_moves_nothing(action):
    env = gymnasium.make("palpate.gym:Palpate-v0", scene="palpation").unwrapped
    before, _ = env.reset(seed=1)
    with pytest.raises(ValueError, match=r"actions are \(n, 6\) numbers"):
        env.step(action)
    after, *_ = env.step([0.0] * 6)
    np.testing.assert_allclose(after["goal"], before["goal"], atol=1e-9)
    env.close()


def test_picture_shows_the_tool_and_passes_the_check():
    pytest.importorskip("moderngl", reason="moderngl (extra learning) is not installed")
    try:
        env = made(picture=(48, 64), duration=0.2)
    except PalpateError as error:
        pytest.skip(error.what)
    check_env(env)
    first, _ = env.reset(seed=0)
    assert first["picture"].shape == (48, 64, 3)
    for _ in range(9):
        last, *_ = env.step([0.05, 0, 0, 0, 0, 0])
    changed = np.abs(first["picture"].astype(int) - last["picture"]).max(axis=2) > 20
    assert 0.002 < changed.mean() < 0.6
    env.close()

"""The port of a device has the axes of the device: no energy is counted of a moment that the hand never feels."""

import numpy as np
import pytest

import palpate
from palpate.base.errors import PalpateError
from palpate.devices.driven import DrivenLoop
from palpate.scene import Scene
from palpate_lab.verify.fuzz.loops.port import rotations, work_held

SCENE = """
objects: [{name: ball, sphere: {radius: 0.03}, stiffness: 500, damping: 0}]
contact: {radius: 0.003, spheres: [{link: tip, at: [0.012, 0, 0.002], radius: 0.004}]}
mapping: {scale: 1}
arms: {follower: {bandwidth: 0}}
operator: {path: [{t: 0, xyz: [0.004, 0, 0.042]}]}
"""


def turning(cycles=12):
    """Poses (n, 4, 4): in, turned there, out, turned back; each cycle takes 1.2 s."""
    s = np.linspace(0, 1, 300)
    ease = s**3 * (10 - 15 * s + 6 * s * s)
    down = np.r_[ease, np.ones(300), 1 - ease, np.zeros(300)]
    turn = np.r_[np.zeros(300), ease, np.ones(300), 1 - ease]
    X = np.tile(np.eye(4), (1200, 1, 1))
    X[:, 2, 3] = -0.012 * down
    X[:, :3, :3] = rotations(turn[:, None] * [0.0, 0.35, 0.1])
    return np.concatenate([X] * cycles)


def felt(scene=SCENE, **options):
    X = turning()
    with palpate.Haptics(Scene.parse(scene), **options) as haptics:
        F = np.array([haptics.step(1e-3 * k, x) for k, x in enumerate(X)])
    return F, X


def test_a_device_without_torque_gains_no_energy():
    F, X = felt()
    assert not F[:, 3:].any()
    assert F[:, :3].any()
    assert work_held(F, X, 3).min() >= -5e-4


@pytest.mark.parametrize("way", ["scene", "argument"])
def test_a_device_with_torque_states_its_moment(way):
    scene = SCENE + "stability: {moment_cap: 0.4}\n" if way == "scene" else SCENE
    F, X = felt(scene, **({} if way == "scene" else {"moment_max": 0.03}))
    most = np.linalg.norm(F[:, 3:], axis=1).max()
    assert 0.0 < most <= (0.4 if way == "scene" else 0.03) * (1 + 1e-9)
    assert work_held(F, X).min() >= -5e-4


def test_a_moment_below_zero_is_refused():
    with pytest.raises(PalpateError, match=r"moment_max = -1 N m: must be 0 or more"):
        palpate.Haptics(Scene.parse(SCENE), moment_max=-1.0)


class Omega:
    rate, force_max, workspace = 1000.0, 12.0, (0.16, 0.16, 0.11)

    def open(self): ...

    def close(self): ...

    def read(self):
        return np.eye(4)

    def write(self, wrench): ...


@pytest.mark.parametrize("most", [0.0, 0.05])
def test_the_cycle_of_a_driver_commands_no_moment_beyond_the_drivers(most):
    driver = Omega()
    driver.moment_max = most
    loop, X = DrivenLoop(Scene.parse(SCENE), driver, "omega"), turning(2)
    F = np.zeros((len(X), 6))
    loop.cycle.replay(1e-3 * np.arange(len(X)), X, F)
    moment = np.linalg.norm(F[:, 3:], axis=1).max()
    assert moment == 0.0 if most == 0.0 else 0.0 < moment <= most * (1 + 1e-9)

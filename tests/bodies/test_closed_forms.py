"""Rigid bodies against closed forms, within 2 %."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("mujoco")

from palpate import _core
from palpate.world.bodies import BodySection, EngineSection, engine
from palpate.world.bodies.engine import JawShape, ToolShape, World

G = 9.81
MU = 0.5
STEP = 0.002
FLOOR = BodySection(
    name="floor", fixed=True, friction=MU, parts=[{"box": (0.8, 0.8, 0.02), "pose": {"xyz": (0, 0, -0.01)}}]
)
BLOCK = {"name": "block", "mass": 0.05, "friction": MU, "touches": False, "parts": [{"box": (0.03, 0.03, 0.01)}],
         "pose": {"xyz": (0, 0, 0.005)}}  # fmt: skip
NOWHERE = ToolShape("far", np.array([[1, 0, 0, 0.0], [0, 1, 0, 0.0], [0, 0, 1, 0.2], [0, 0, 0, 1]], float), (), 0.002)


def world_of(bodies, tools=(NOWHERE,), **section):
    section = {"stiffness": 500.0} | section
    world = World([BodySection.model_validate(b) if isinstance(b, dict) else b for b in bodies],
                  EngineSection(**section), tools)  # fmt: skip
    return world, world.core(_core.Snapshot([]))


def pushed(share, mass, seconds=0.5):
    """Acceleration of a block under a share of the Coulomb limit along x [m/s^2], by its way in a time."""
    world, core = world_of([FLOOR, BLOCK | {"mass": mass}])
    load = world.data.xfrc_applied[world.model.body("block").id]
    for _ in range(100):
        core.advance(STEP)
    x = core.states()["poses"][0, 0]
    load[0] = share * MU * mass * G
    for _ in range(round(seconds / STEP)):
        core.advance(STEP)
    return 2.0 * (core.states()["poses"][0, 0] - x) / seconds**2


@pytest.mark.parametrize("mass", [0.001, 0.05])
def test_a_block_sticks_up_to_the_coulomb_limit_and_slips_beyond(mass):
    assert abs(pushed(0.98, mass)) < 2e-3
    assert pushed(1.02, mass) > 0.05, "it slips two per cent above the limit"
    assert pushed(1.25, mass) == pytest.approx(0.25 * MU * G, rel=0.02)  # a = (F - limit) / m


@pytest.mark.parametrize("degrees", [30.0, 35.0, 45.0])
def test_a_block_slides_down_an_incline_as_newton_says(degrees):
    block = BLOCK | {"pose": {"xyz": (-0.2, 0, 0.005)}}
    world, core = world_of([FLOOR, block], field=((-1, -1, -1), (1, 1, 1)))
    joint = world.model.joint("block/free")
    for k in range(150):
        angle = np.radians(degrees) * k / 149
        world.model.opt.gravity[:] = (G * np.sin(angle), 0.0, -G * np.cos(angle))
        core.advance(STEP)
    for _ in range(20):
        core.advance(STEP)
    v = float(world.data.qvel[joint.dofadr[0]])
    for _ in range(100):
        core.advance(STEP)
    a = (float(world.data.qvel[joint.dofadr[0]]) - v) / (100 * STEP)
    friction = (G * np.sin(angle) - a) / (G * np.cos(angle))
    assert friction == pytest.approx(MU, rel=0.02)
    assert a == pytest.approx(G * (np.sin(angle) - MU * np.cos(angle)), rel=0.02)


def jaws(radius=0.002):
    """Jaws along -z of W that open along x."""
    X_WT = np.diag([1.0, -1.0, -1.0, 1.0])
    X_WT[:3, 3] = [0, 0, 0.1]
    made = []
    for sign in (1.0, -1.0):
        tip = np.array([sign * 0.0011, 0.0, 0.018])
        made.append(JawShape(np.zeros(3), np.array([0.0, sign, 0.0]), 0.5, np.zeros(3), tip, 0.0017))
    return ToolShape("tool", X_WT, tuple(made), radius)


def held(pieces, seconds=0.6, jaw=0.0, **section):
    """A body between closed jaws without gravity, and the world."""
    tool = jaws()
    opened = {"gravity": (0.0, 0.0, 0.0), "grip": 0.02} | section
    world, core = world_of([pieces], (tool,), **opened)
    core.drive(0, tool.X_WT, 0.6)
    for k in range(round(seconds / STEP)):
        core.drive(0, tool.X_WT, max(0.6 - 3.0 * k * STEP, jaw))
        core.advance(STEP)
    return world, core, tool


def test_jaws_lose_a_body_at_the_friction_of_both_fingers(monkeypatch):
    monkeypatch.setattr(engine, "_STIFFNESS_W", 5.0)  # the tool keeps its orientation under the pull
    plate = {"name": "plate", "mass": 0.01, "friction": 0.1, "touches": False, "pose": {"xyz": (0, 0, 0.0845)},
             "parts": [{"box": (0.003, 0.02, 0.003)}]}  # fmt: skip
    world, core, tool = held(plate)
    N = float(core.states()["grip"][0, 0])
    # The torque of the drive over its lever: it presses at the plate's upper edge, 14 mm from the hinge.
    assert pytest.approx(0.02 / 0.014, rel=0.02) == N
    slope = 0.5 * float(
        world.data.qpos[world.model.joint("tool/jaw0").qposadr[0]]
        - world.data.qpos[world.model.joint("tool/jaw1").qposadr[0]]
    )
    load = world.data.xfrc_applied[world.model.body("plate").id]
    virtual = world.data.body("tool/tool")  # it gives way with the coupling

    def along():
        return float((virtual.xmat.reshape(3, 3).T @ (core.states()["poses"][0, :3] - virtual.xpos))[1])

    y0, pull = along(), 0.0
    while pull < 5.0 and abs(along() - y0) < 1e-3:
        pull += 0.002
        load[1], load[3] = pull, -0.0015 * pull  # at the plate's upper edge, where the jaws press
        for _ in range(4):
            core.drive(0, tool.X_WT, 0.0)
            core.advance(STEP)
    mu = 0.8  # of the jaws, the larger one of both
    # The faces stand at an angle, and friction also keeps them from pushing the plate out.
    limit = 2.0 * N * np.sqrt((mu * np.cos(slope)) ** 2 - np.sin(slope) ** 2)
    assert pull == pytest.approx(limit, rel=0.02)


@pytest.mark.parametrize(("share", "holds"), [(1.03, True), (0.96, False)])
def test_two_hands_squeeze_and_lift_by_friction(share, holds):
    m, mu, K = 0.02, 0.8, 500.0
    box = {"name": "box", "mass": m, "friction": 0.1, "touches": False, "pose": {"xyz": (0, 0, 0.1)},
           "parts": [{"box": (0.02, 0.02, 0.02)}]}  # fmt: skip
    places = []
    for side in (-1.0, 1.0):
        X = np.eye(4)
        X[:3, 3] = [side * 0.0125, 0, 0.1]
        places.append(X)
    tools = [ToolShape(name, X, (), 0.002) for name, X in zip(("a", "b"), places, strict=True)]
    world, core = world_of([box], tools, gravity=(0.0, 0.0, 0.0))
    wanted = share * m * G / (2.0 * mu)
    squeeze, goal = 0.0, [X.copy() for X in places]
    for k in range(600):
        for n, side in enumerate((-1.0, 1.0)):
            goal[n][0, 3] = side * (0.0125 - min(k / 200.0, 1.0) * (0.0005 + squeeze))
            core.drive(n, goal[n], 0.0)
        core.advance(STEP)
        if k > 200:  # two hands that regulate their force
            squeeze += 0.05 * (wanted + core.drive(0, goal[0], 0.0)[0][0]) / K
    assert core.drive(0, goal[0], 0.0)[0][0] == pytest.approx(-wanted, rel=0.005)
    for k in range(300):  # the weight comes slowly
        world.model.opt.gravity[2] = -G * min(k / 150.0, 1.0)
        for n in range(2):
            core.drive(n, goal[n], 0.0)
        core.advance(STEP)
    fallen = 0.1 - core.states()["poses"][0, 2]
    assert bool(fallen < 0.002) is holds


def test_a_pendulum_in_the_jaws_has_the_period_of_a_compound_pendulum():
    length, r = 0.03, 0.002
    bob = {"name": "bob", "density": 1000.0, "friction": 0.1, "torsion": 0.0, "touches": False,
           "pose": {"xyz": (0, 0, 0.085)}, "parts": [
                     {"sphere": r}, {"box": (0.001, 0.001, length), "pose": {"xyz": (0, 0, -0.5 * length)}},
                     {"sphere": 0.006, "pose": {"xyz": (0, 0, -length)}}]}  # fmt: skip
    world, core, tool = held(bob, grip=0.04)
    k = world.model.body("bob").id
    mass, com = float(world.model.body_mass[k]), np.array(world.model.body_ipos[k])
    # The jaws open along x: the bob swings about x.
    inertia = np.array(world.model.body_inertia[k])
    R = np.zeros(9)
    import mujoco

    mujoco.mju_quat2Mat(R, world.model.body_iquat[k])
    about_x = float((R.reshape(3, 3) @ np.diag(inertia) @ R.reshape(3, 3).T)[0, 0]) + mass * float(com[2] ** 2)
    world.model.opt.gravity[2] = -G
    world.data.qvel[world.model.joint("bob/free").dofadr[0] + 3] = 1.5
    angles = []
    for _ in range(round(1.5 / STEP)):
        core.drive(0, tool.X_WT, 0.0)
        core.advance(STEP)
        q = core.states()["poses"][0, 3:]
        angles.append(2.0 * np.arctan2(q[1], q[0]))
    angles = np.array(angles)
    assert np.abs(angles).max() > 0.01
    rising = np.flatnonzero((angles[:-1] < 0.0) & (angles[1:] >= 0.0))
    assert len(rising) >= 3
    period = (rising[-1] - rising[0]) * STEP / (len(rising) - 1)
    assert period == pytest.approx(2.0 * np.pi * np.sqrt(about_x / (mass * G * abs(com[2]))), rel=0.02)

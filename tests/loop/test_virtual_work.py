"""Closed slow loops of the hand yield no energy, whatever maps lie between hand and tool: own quadrature."""

import numpy as np
import pytest
import yaml
from scipy.spatial.transform import Rotation

import palpate
from palpate.scene.scene import Scene

SETTLE = 800
"""Steps before the loop, in which fixtures engage."""
WALL = {"plane": {"size": 0.3}}
SLOPE = {"plane": {"at": [0.0, 0.0, 0.0035], "normal": [0.3, 0.1, 0.95]}}
OTHER = {"plane": {"at": [0.0, 0.0, 0.003], "normal": [-0.5, 0.15, 0.85]}}
BALL = {"sphere": {"radius": 0.028, "at": [0.004, 0.003, -0.025]}}
ROOM = {"sphere": {"radius": 0.02, "at": [0.0, 0.003, 0.018]}}
LINE = {"line": {"start": [-0.1, 0.0, 0.0025], "end": [0.1, 0.012, -0.003]}}
SQUARE = ((0, 0, 0), (0, 0, -11), (9, 3, -11), (9, 3, 0), (0, 0, 0))
"""Corners of the hand's path, from its start [mm]."""


def hard(geometry, role="forbid", name="one", **more):
    return {"name": name, "geometry": geometry, "role": role, "hard": True,
            "law": {"name": "spring", "stiffness": 450, "damping": 0}} | more  # fmt: skip


def soft(geometry, role, **more):
    return hard(geometry, role, **more) | {"hard": False}


def scene(*fixtures, scale=1.0, leader=None, **wall):
    arms = {"follower": {"bandwidth": 0}} | ({} if leader is None else {"leader": {"base": leader}})
    return Scene.parse(yaml.safe_dump({
        "objects": [{"name": "wall", "stiffness": 700, "friction": 0} | ({} if "sphere" in wall else WALL) | wall],
        "guidance": list(fixtures),
        "contact": {"radius": 0.002},
        "mapping": {"scale": scale},
        "arms": arms,
        "operator": {"path": [{"t": 0, "xyz": [0.0, 0.0, 0.007]}]},
        "stability": {"passivity": "off", "rate_cap": 1e5, "force_cap": 30, "moment_cap": 2, "moment_rate_cap": 1e4},
    }))  # fmt: skip


def loop(given, corners=SQUARE, turns=None, reverse=False, side=1200):
    """Energy that the hand puts in along a closed path, and the largest on the way [mJ]; wrenches (n, 6)."""
    p = 1e-3 * np.array(corners, float)
    w = np.zeros_like(p) if turns is None else np.array(turns, float)
    if reverse:
        p, w = p[::-1], w[::-1]
    t = np.linspace(0.0, len(p) - 1, side * (len(p) - 1) + 1)
    p = np.c_[[np.interp(t, range(len(p)), x) for x in p.T]].T
    R = Rotation.from_rotvec(np.c_[[np.interp(t, range(len(w)), x) for x in w.T]].T)
    F, X = np.zeros((len(t), 6)), np.eye(4)
    with palpate.Haptics(given) as haptics:
        for k in range(-SETTLE, len(t)):
            X[:3, 3], X[:3, :3] = p[max(k, 0)], R[max(k, 0)].as_matrix()
            F[k] = haptics.step(1e-3 * (k + SETTLE), X)
    d = np.c_[np.diff(p, axis=0), (R[1:] * R[:-1].inv()).as_rotvec()]
    energy = -1e3 * np.cumsum((0.5 * (F[1:] + F[:-1]) * d).sum(axis=1))
    return energy[-1], np.ptp(energy), F


HARD = {
    "slope": [hard(SLOPE)],
    "ball": [hard(BALL)],
    "room": [hard(ROOM, "keep-in")],
    "line": [hard(LINE, "guide")],
    "two slopes": [hard(SLOPE, name="a"), hard(OTHER, name="b")],
    "two slopes, one softer": [
        hard(SLOPE, name="a"),
        hard(OTHER, name="b", law={"name": "spring", "stiffness": 200, "damping": 0}),
    ],
    "slope and room": [hard(SLOPE, name="a"), hard(ROOM, "keep-in", name="b")],
    "half the authority": [hard(SLOPE, authority=0.55)],
    "pulled by a soft guide": [hard(SLOPE, name="a"), soft(LINE, "guide", name="b")],
    "capped law": [hard(SLOPE, law={"name": "optimise", "stiffness": 450, "damping": 0, "force": 0.8})],
}


@pytest.mark.parametrize("reverse", [False, True])
@pytest.mark.parametrize("name", HARD)
def test_hard_fixture_above_a_surface_yields_no_energy(name, reverse):
    left, exchanged, F = loop(scene(*HARD[name]), reverse=reverse)
    assert exchanged > 2.0, "control: the loop loads springs"
    assert abs(left) < 0.15, f"{left:.3f} of {exchanged:.1f} mJ"
    assert np.abs(F[:, :3]).max() < 30.0, "control: no cap acts"


def test_scale_and_turned_base_leave_the_law():
    given = scene(*HARD["ball"], scale=0.6, leader={"xyz": [0.1, 0.0, 0.2], "rpy_deg": [20.0, -35.0, 70.0]})
    turn = Rotation.from_euler("xyz", [20.0, -35.0, 70.0], degrees=True)
    corners = turn.inv().apply(SQUARE) / 0.6
    for reverse in (False, True):
        left, exchanged, _ = loop(given, corners, reverse=reverse)
        assert exchanged > 2.0
        assert abs(left) < 0.15


def test_force_does_not_step_where_a_hard_fixture_begins_to_hold_a_pressed_tool():
    """The plane is parallel to the wall and 3 mm below it: the wall's 3.5 N stay, and the fixture's spring adds."""
    low = {"plane": {"at": [0.0, 0.0, -0.003], "normal": [0.0, 0.0, 1.0]}}
    _, _, F = loop(scene(hard(low)), ((0, 0, 0), (0, 0, -14), (0, 0, 0)), side=3000)
    assert F[:, 2].max() == pytest.approx(700 * 0.005 + 450 * 0.004, rel=0.03)
    assert np.abs(np.diff(F[:, 2])).max() < 0.03, "no step between ticks"


@pytest.mark.parametrize("reverse", [False, True])
@pytest.mark.parametrize("shape", [WALL, {"sphere": {"radius": 0.05}}], ids=["plane", "sphere"])
def test_stiffness_of_three_axes_is_a_spring_on_every_slope(shape, reverse):
    ball = "sphere" in shape
    pose = {"xyz": [0.02, 0.01, -0.045]} if ball else {"xyz": [0, 0, 0], "rpy_deg": [0, 35, 0]}
    given = scene(stiffness=[400, 700, 1100], pose=pose, **shape)
    left, exchanged, _ = loop(given, reverse=reverse)
    assert exchanged > 3.0, "control: the loop loads springs"
    assert abs(left) < 0.1 + 2e-3 * exchanged, f"{left:.3f} of {exchanged:.1f} mJ: the tool follows one tick later"


REACH = 0.2334
"""Distance of the tip from the remote centre of the shipped follower, at the end of its shaft [m]."""


def at_the_end_of_the_shaft(tilt, start=0.963, **contact):
    """A scene whose tool starts near the end of its reach, and the direction of its shaft; tilt: [rad] about y."""
    a = np.array([np.sin(tilt), 0.0, -np.cos(tilt)])
    tip = np.array([0.0, 0.0, 0.007])
    given = scene(**contact).model_dump(mode="json", exclude_unset=True)
    given["arms"]["follower"] |= {"base": {"xyz": [float(x) for x in tip - start * REACH * a], "rpy_deg": [0, 0, 0]}}
    return Scene.parse(yaml.safe_dump(given)), a


@pytest.mark.parametrize("tilt", [0.0, 0.2, -0.35, 0.5])
@pytest.mark.parametrize("reverse", [False, True])
@pytest.mark.parametrize("wall", [WALL, {"sphere": {"radius": 0.02}, "pose": {"xyz": [0.004, 0.002, -0.02]}}])
def test_loops_beyond_the_reach_of_the_follower_yield_nothing(tilt, reverse, wall):
    given, _ = at_the_end_of_the_shaft(tilt, **wall)
    corners = [(x, y, 1.5 * z) for x, y, z in SQUARE]
    for turns in (None, [(0, 0, 0), (0.2, 0.1, 0), (0.1, -0.3, 0.2), (0, 0.2, 0), (0, 0, 0)]):
        energy, stored, _ = loop(given, corners, turns, reverse, side=2400)
        assert stored > 0.3
        assert abs(energy) < 4e-3 * stored + 2e-3


def test_hand_beyond_the_reach_feels_the_force_across_the_shaft():
    """The tip stays on the sphere of its reach, so the hand feels L / (L + d) (I - a a^T) times the force on it."""
    given, a = at_the_end_of_the_shaft(0.4, start=0.963)
    out, X = 1e-3 * np.linspace(0, 16, 3000), np.eye(4)
    with palpate.Haptics(given) as haptics:
        for k, d in enumerate(out):
            X[:3, 3] = d * a
            F = haptics.step(1e-3 * k, X)[:3]
        assert np.linalg.norm(F) > 0.2
    reached = REACH * a * (1 - 0.963) + [0.0, 0.0, 0.007]
    pressed = 700.0 * (0.002 - reached[2]) * np.array([0.0, 0.0, 1.0])
    beyond = 0.016 - (1 - 0.963) * REACH
    felt = REACH / (REACH + beyond) * (pressed - a * (a @ pressed))
    np.testing.assert_allclose(F, felt, atol=0.02 * pressed[2])

"""Bodies that are dropped, thrown, stuck or no longer finite; joints, meshes, and objects of the scene."""

from __future__ import annotations

import gc

import numpy as np
import pytest

pytest.importorskip("mujoco")

import trimesh
from test_closed_forms import BLOCK, FLOOR, STEP, G, held, world_of

from palpate import _core
from palpate.record.ticks import as_ticks
from palpate.scene import Scene
from palpate.scene.rig import build
from palpate.session import Session
from palpate.world.bodies import BodySection, EngineSection
from palpate.world.bodies.engine import ToolShape, World

PLATE = {"name": "plate", "mass": 0.004, "friction": 0.1, "touches": False, "pose": {"xyz": (0, 0, 0.0845)},
         "parts": [{"box": (0.003, 0.02, 0.003)}]}  # fmt: skip


def advance(core, n):
    for _ in range(n):
        core.advance(STEP)


@pytest.mark.parametrize(("what", "lost"), [("qvel", 1), ("qpos", 1), ("jaw", 0)])
def test_after_a_nan_everything_is_finite_and_the_tool_is_felt_again(what, lost, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # the engine writes a log of its warnings
    world, core, tool = held(BLOCK | {"pose": {"xyz": (0, 0, 0.05)}}, seconds=0.1)
    if what == "jaw":
        world.data.qvel[world.model.joint("tool/jaw0").dofadr[0]] = np.nan
    else:
        getattr(world.data, what)[0] = np.nan
    for _ in range(5):
        F, _ = core.drive(0, tool.X_WT, 0.0)
        core.advance(STEP)
    assert np.isfinite(F).all()
    assert np.isfinite(world.data.qpos).all()
    assert np.isfinite(world.data.qvel).all()
    states = core.states()
    assert states["lost"].tolist() == [lost]
    assert states["poses"][0, :3] == pytest.approx([0, 0, 0.05], abs=1e-9)


def test_a_thrown_body_returns_to_its_start_and_the_others_stay():
    world, core = world_of([FLOOR, BLOCK, BLOCK | {"name": "other", "pose": {"xyz": (0, 0.1, 0.005)}}])
    advance(core, 50)
    world.data.qvel[world.model.joint("block/free").dofadr[0]] = 5.0
    advance(core, 50)
    states = core.states()
    assert states["lost"].tolist() == [1, 0]
    assert states["poses"][:, :2] == pytest.approx(np.array([[0.0, 0.0], [0.0, 0.1]]), abs=1e-3)


def test_a_held_body_that_is_let_go_falls_to_the_floor():
    _, core, tool = held(PLATE, gravity=(0, 0, -G), grip=0.04)
    assert core.states()["grip"][0, 0] > 0.1
    high = core.states()["poses"][0, 2]
    for k in range(60):
        core.drive(0, tool.X_WT, min(0.02 * k, 0.6))
        core.advance(STEP)
    assert core.states()["grip"][0, 0] == 0.0
    assert core.states()["poses"][0, 2] < high - 0.01


def test_a_stuck_tool_pushes_at_most_force_max_and_is_freed_at_the_release():
    X = np.eye(4)
    X[2, 3] = 0.01
    _, core = world_of([FLOOR], (ToolShape("a", X, (), 0.002),), force_max=4.0, release=0.02)
    for depth in np.linspace(-0.01, 0.012, 200):  # T below the floor's upper side
        X[2, 3] = -depth
        F = core.drive(0, X, 0.0)[0]
        core.advance(STEP)
    assert F[2] == pytest.approx(4.0, rel=0.01)
    X[2, 3] = -0.1  # below the whole floor
    core.drive(0, X, 0.0)
    advance(core, 5)
    assert np.linalg.norm(core.drive(0, X, 0.0)[0]) < 1e-6


def test_a_hinged_bar_swings_through_the_post_that_carries_it():
    post = {"name": "post", "fixed": True, "pose": {"xyz": (0, 0, 0.1)}, "parts": [{"box": (0.01, 0.01, 0.01)}]}
    m, c, size = 0.02, 0.03, (0.004, 0.004, 0.06)
    bar = {"name": "bar", "mass": m, "parts": [{"box": size, "pose": {"xyz": (0, 0, -c)}}],
           "joint": {"to": "post", "kind": "hinge", "axis": (1, 0, 0)}}  # fmt: skip
    world, core = world_of([post, bar])
    at = world.model.joint("bar/joint").qposadr[0]
    world.data.qpos[at] = 0.05
    angles = []
    for _ in range(700):
        core.advance(STEP)
        angles.append(float(world.data.qpos[at]))
    angles = np.array(angles)
    rising = np.flatnonzero((angles[:-1] < 0.0) & (angles[1:] >= 0.0))
    inertia = m * (size[1] ** 2 + size[2] ** 2) / 12.0 + m * c**2
    period = (rising[-1] - rising[0]) * STEP / (len(rising) - 1)
    assert period == pytest.approx(2.0 * np.pi * np.sqrt(inertia / (m * G * c)), rel=0.02)


def test_welded_bodies_move_as_one():
    lid = {"name": "lid", "mass": 0.01, "parts": [{"sphere": 0.006}], "pose": {"xyz": (0, 0, 0.006)},
           "joint": {"to": "block", "kind": "weld"}}  # fmt: skip
    world, core = world_of([FLOOR, BLOCK, lid])
    advance(core, 100)
    drawn = world.drawn()
    assert (drawn["lid"] - drawn["block"])[:3] == pytest.approx([0, 0, 0.006], abs=1e-4)
    assert drawn["block"][2] == pytest.approx(0.005, abs=2e-4)


def test_a_mesh_weighs_and_rests_as_the_box_that_it_is(tmp_path):
    trimesh.creation.box((0.03, 0.02, 0.01)).export(tmp_path / "box.stl")
    mesh = {"name": "mesh", "density": 1000.0, "pose": {"xyz": (0, 0, 0.006)},
            "parts": [{"mesh": "box.stl", "unit": "m"}]}  # fmt: skip
    bodies = [FLOOR, BodySection.model_validate(mesh)]
    far = ToolShape("far", np.diag([1.0, 1.0, 1.0, 1.0]) + 0.2 * np.eye(4, k=1), (), 0.002)
    world = World(bodies, EngineSection(), (far,), lambda name: tmp_path / name)
    core = world.core(_core.Snapshot([]))
    advance(core, 150)
    k = world.model.body("mesh").id
    assert float(world.model.body_mass[k]) == pytest.approx(0.006, rel=1e-3)
    assert world.shapes["mesh"][0].volume == pytest.approx(6e-6, rel=1e-5)
    assert sorted(world.model.body_inertia[k]) == pytest.approx(
        sorted(0.006 / 12.0 * np.array([0.02**2 + 0.01**2, 0.03**2 + 0.01**2, 0.03**2 + 0.02**2])), rel=1e-3
    )
    assert core.states()["poses"][0, 2] == pytest.approx(0.005, abs=1e-4)


def test_parts_share_the_mass_by_volume_as_one_density_would():
    parts = [{"box": (0.02, 0.02, 0.02)}, {"sphere": 0.004, "pose": {"xyz": (0, 0, 0.03)}},
             {"cylinder": {"radius": 0.003, "length": 0.01}, "pose": {"xyz": (0.02, 0, 0)}},
             {"capsule": {"radius": 0.002, "length": 0.01}, "pose": {"xyz": (0, 0.02, 0)}}]  # fmt: skip
    dense, _ = world_of([{"name": "a", "density": 800.0, "parts": parts}])
    m = float(dense.model.body("a").mass[0])
    assert m == pytest.approx(800.0 * (8e-6 + 4 / 3 * np.pi * (0.004**3 + 0.002**3) + np.pi * (9e-8 + 4e-8)), rel=1e-6)
    given, _ = world_of([{"name": "a", "mass": m, "parts": parts}])
    for of in ("mass", "ipos", "inertia"):
        assert getattr(given.model.body("a"), of) == pytest.approx(getattr(dense.model.body("a"), of), rel=1e-6)


def test_a_ball_sinks_into_an_object_of_the_scene_by_its_weight_over_the_stiffness():
    m, K = 0.02, 500.0
    table = build(Scene.model_validate({"objects": [{"name": "table", "plane": {"size": 0.2}, "stiffness": K,
                                                     "damping": 5}]})).snapshot  # fmt: skip
    ball = BodySection.model_validate({"name": "ball", "mass": m, "parts": [{"sphere": 0.005}],
                                       "pose": {"xyz": (0, 0, 0.006)}})  # fmt: skip
    X = np.eye(4)
    X[:3, 3] = [0, 0, 0.04]
    world = World([ball], EngineSection(), (ToolShape("a", X, (), 0.002),))
    core = world.core(table)
    advance(core, 500)
    assert 0.005 - core.states()["poses"][0, 2] == pytest.approx(m * G / K, rel=0.02)
    for z in np.linspace(0.03, 0.009, 400):  # a tool presses the ball into the table, and feels the table
        X[2, 3] = z
        F = core.drive(0, X, 0.0)[0]
        core.advance(STEP)
    for _ in range(300):
        F = core.drive(0, X, 0.0)[0]
        core.advance(STEP)
    depth = 0.005 - core.states()["poses"][0, 2]
    assert F[2] > 0.2
    assert K * depth == pytest.approx(m * G + F[2], rel=0.02)


def test_a_loop_keeps_the_engine_of_a_session_that_is_gone():
    simulation = Session(Scene.load("tray_cubes")).simulation
    gc.collect()
    assert np.isfinite(as_ticks(simulation.run(300))["p_WT"]).all()

"""Threads among tools: jaws hold them by friction, shafts push them, and the hand gets no energy."""

from __future__ import annotations

import numpy as np
import pytest
from test_bodies_energy import ALLOWANCE, LEADERS, scene_of
from test_closed_forms import STEP, held

pytest.importorskip("mujoco")

from palpate.scene import Scene
from palpate.session import Session
from palpate.world.bodies import engine

THREAD = {"links": 12, "length": 0.05}


def needle(**thread):
    """A needle of 0.3 g at the side of the jaws of `held`, whose thread runs between them."""
    part = {"capsule": {"radius": 0.0006, "length": 0.012}, "pose": {"rpy_deg": (0, 90, 0)}}
    pose = {"xyz": (0, -0.025, 0.085), "rpy_deg": (-90, 0, 0)}
    return {
        "name": "needle", "mass": 0.0003, "touches": False, "pose": pose, "parts": [part], "thread": THREAD | thread,
    }  # fmt: skip


@pytest.mark.parametrize(("radius", "links"), [(0.0003, 12), (0.0005, 12), (0.0003, 25)])
def test_a_thread_slips_through_the_jaws_at_the_friction_of_both(monkeypatch, radius, links):
    monkeypatch.setattr(engine, "_STIFFNESS_W", 5.0)  # the tool keeps its orientation under the pull
    world, core, tool = held(needle(radius=radius, links=links))
    load = world.data.xfrc_applied[world.model.body("needle").id]
    virtual = world.data.body("tool/tool")  # it gives way with the coupling

    def along():
        return float(core.states()["poses"][0, 1] - virtual.xpos[1])

    y0, pull, F = along(), 0.0, 0.0
    while pull < 3.0 and abs(along() - y0) < 2e-3:
        F = float(core.states()["grip"][0, 0])  # of a jaw: it presses with N and rubs with mu N
        pull += 0.002
        load[1] = -pull
        for _ in range(4):
            core.drive(0, tool.X_WT, 0.0)
            core.advance(STEP)
    mu = 0.8  # of the jaws
    assert F > 0.2
    assert pull == pytest.approx(2.0 * mu * F / np.hypot(1.0, mu), rel=0.02)


def test_open_jaws_let_a_thread_go():
    world, core, tool = held(needle(), jaw=0.3)
    assert core.states()["grip"][0, 0] == 0.0
    load = world.data.xfrc_applied[world.model.body("needle").id]
    load[1] = -0.001
    for _ in range(100):
        core.drive(0, tool.X_WT, 0.3)
        core.advance(STEP)
    assert core.states()["poses"][0, 1] < -0.03


def scene_with_thread(leader, path, **stability):
    """A PSM beside a thread that hangs from a fixed bar of 3 cm above the origin."""
    scene = scene_of(leader, 0.05, np.random.default_rng(0), **stability).model_dump(mode="json", exclude_unset=True)
    bar = {"name": "bar", "fixed": True, "parts": [{"box": [0.004, 0.06, 0.004]}], "pose": {"xyz": [0.02, 0, 0.14]}}
    ring = {"name": "ring", "mass": 0.001, "parts": [{"box": [0.006, 0.006, 0.006]}],
            "pose": {"xyz": [0.02, 0, 0.137], "rpy_deg": [180, 0, 0]}, "joint": {"to": "bar", "kind": "weld"},
            "thread": {"links": 20, "length": 0.12, "radius": 0.0004}}  # fmt: skip
    bodies = [one for one in scene["bodies"] if one["name"] == "floor"]
    return Scene.model_validate(scene | {"bodies": [*bodies, bar, ring], "operator": {"path": path, "hand": "relaxed"}})


def test_a_shaft_pushes_a_hanging_thread_aside():
    path = [{"t": 0.0, "xyz": [0, 0, 0.06]}, {"t": 1.5, "xyz": [0.04, 0, 0.06]}, {"t": 2.0, "xyz": [0.04, 0, 0.06]}]
    session = Session(scene_with_thread(LEADERS["mtm_right"], path))
    session.run(2.0)
    links = np.array([session.world.drawn()[f"ring/thread{k}"][:3] for k in range(20)])
    assert links[:, 0].max() > 0.035, "the instrument has taken it along"


@pytest.mark.parametrize("leader", LEADERS)
def test_motions_among_threads_give_the_hand_no_energy(leader):
    for seed, alone in ((0, {}), (1, {"passivity": "off", "force_cap": 20.0, "rate_cap": 15000.0})):
        rng = np.random.default_rng([seed, list(LEADERS).index(leader)])
        path = [{"t": 0.3 * k, "xyz": rng.uniform([0.0, -0.01, 0.03], [0.04, 0.01, 0.08]).tolist()} for k in range(9)]
        path[0]["xyz"] = [0.0, 0.0, 0.06]
        summary = Session(scene_with_thread(LEADERS[leader], path, **alone), seed=seed).run(2.4)
        assert summary.energy_min_J >= -1.02 * ALLOWANCE

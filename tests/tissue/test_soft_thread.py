"""Soft bodies on a thread of their own: force, energy, bytes, a thread that is late, and the choice of the thread."""

from __future__ import annotations

import time

import numpy as np
import pytest
from soft_bodies import lockstep, soft_cube

import palpate
from palpate import _core
from palpate.base.errors import SceneError, SurfaceError
from palpate.scene.contact import render
from palpate.world.tissue.body import MOST_IN_CYCLE, PERIOD
from palpate_lab.verify.bench.tissue import threads as bench

R, UP = bench.RADIUS, np.array([0.0, 0.0, 1.0])


@pytest.mark.parametrize("young", [5e3, 60e3])
def test_body_on_a_thread_feels_as_in_the_cycle_and_gives_no_energy(young):
    found = bench.apart(young, rates=[4.0])
    assert found["rms"] < 0.015
    assert found["peak"] < 0.1
    assert found["taken"] > -1e-6


def test_the_comparison_sees_a_force_that_is_held():
    """Control: a force held for 20 ms differs, and gives energy when the tool oscillates."""
    path = bench.oscillation(4.0)
    force = render(bench.slab(20e3, "cycle"), path, radius=R).force
    held = np.repeat(force[::20], 20, axis=0)[: len(force)]
    late = np.concatenate([np.zeros((20, 3)), held[:-20]])
    assert bench.taken(force, path) > -1e-6
    assert bench.taken(late, path) < -1e-6


def test_renderings_with_a_thread_repeat_their_bytes():
    first, second = (render(bench.slab(5e3, "own"), bench.palpation(), radius=R).force.tobytes() for _ in range(2))
    assert first == second


def own(period=4e-3):
    return bench.slab(5e3, "own", period).core.own()


def press(surface, ticks, depth=2e-3):
    """Forces of a sphere that rests at a depth below the plane z = 0."""
    forces = []
    for _ in range(ticks):
        force = surface.respond(np.zeros(3), UP, depth, R)
        surface.advance(np.zeros(3), UP, depth, R, force * UP)
        forces.append(force)
    return np.array(forces)


def test_stalled_thread_is_told_and_its_force_fades_and_returns():
    surface = own()
    surface.set_beside(True)
    for _ in range(25):  # a thread that does its work
        press(surface, 4)
        surface.work()
    force = press(surface, 1)[0]
    assert force > 0.02
    assert not surface.state()[4]
    late = press(surface, 40)
    assert surface.state()[4], "the shape is overdue"
    assert late[-1] == pytest.approx(force, rel=0.2), "the local law goes on"
    faded = press(surface, 150)
    assert (np.diff(faded) <= 1e-9).all()
    assert faded[-1] == 0.0
    back = []
    for _ in range(100):
        surface.work()
        back.append(press(surface, 4)[-1])
    assert not surface.state()[4]
    assert back[-1] == pytest.approx(force, rel=0.1)
    assert np.abs(np.diff(back)).max() < 0.1 * force, "it returns by a ramp"


def test_large_bodies_get_a_thread_by_themselves_unless_asked_otherwise():
    small = bench.slab(5e3, "auto")
    assert small.period == 0.0
    assert len(small.tets) / small.body.time_step < MOST_IN_CYCLE
    fine = bench.slab(5e3, "auto", PERIOD, step=1e-5)
    assert fine.period == PERIOD
    assert fine.core.period == PERIOD
    assert bench.slab(5e3, "cycle", PERIOD, step=1e-5).period == 0.0
    with pytest.raises(SurfaceError, match="thread = 'other'"):
        bench.slab(5e3, "other")
    with pytest.raises(SurfaceError, match=r"period = 0\.1"):
        bench.slab(5e3, "own", 0.1)


SCENE = """
objects:
  - name: cube
    box: {{size: [0.06, 0.06, 0.04]}}
    unit: m
    tissue:
      {{volume: cube.vtk, fixed: [{{at: [0, 0, -0.02], box: [0.2, 0.2, 0.002]}}], thread: {thread}, period: 10 ms}}
contact: {{radius: 0.006}}
operator: {{palpate: {{approach: 0.3, press: 1.0, force: 0.25}}}}
"""


def test_session_with_a_thread_has_the_energies_of_the_cycle(tmp_path):
    ticks = {
        name: lockstep(palpate.Session(soft_cube(tmp_path, SCENE.format(thread=name))), 1400)
        for name in ("cycle", "own")
    }
    potential = {name: t["tissue_potential"] for name, t in ticks.items()}
    top = potential["cycle"].max()
    assert top > 2e-5
    assert np.abs(potential["own"] - potential["cycle"]).max() < 0.1 * top
    assert ticks["own"]["energy_port"].min() > -0.5e-3
    force = {name: np.linalg.norm(t["F_T_W"], axis=1) for name, t in ticks.items()}
    apart = force["own"] - force["cycle"]
    assert np.sqrt((apart**2).mean()) < 0.03 * np.sqrt((force["cycle"] ** 2).mean())
    assert (ticks["own"]["status"] & bench.LATE == 0).all()
    assert potential["own"].tobytes() != potential["cycle"].tobytes(), "control: it has a thread"


def test_recorded_motions_give_the_same_wrenches_at_any_speed(tmp_path):
    """Steps of `palpate.Haptics` as fast as they compute, in fits and starts, and without a rest again."""
    above = "operator: {path: [{t: 0, xyz: [0, 0, 0.03]}, {t: 1, xyz: [0, 0, 0.03]}]}\nmapping: {scale: 1.0}\n"
    text = SCENE.format(thread="own").replace("10 ms", "4 ms").split("operator")[0] + above
    soft_cube(tmp_path, text)
    t = np.arange(600) * 1e-3
    rng = np.random.default_rng(3)
    found = []
    for pauses in (np.zeros(600), np.where(rng.random(600) < 0.05, 2e-4, 0.0), np.zeros(600)):
        with palpate.Haptics(tmp_path / "soft.yaml", rate=1000.0) as haptics:
            wrenches = []
            for now, pause in zip(t, pauses, strict=True):
                X = np.eye(4)
                X[2, 3] = -0.02 * min(now, 0.4)
                wrenches.append(haptics.step(now, X))
                time.sleep(pause)
        found.append(np.array(wrenches))
    assert np.linalg.norm(found[0], axis=1).max() > 0.05, "it presses the tissue"
    assert found[0].tobytes() == found[1].tobytes() == found[2].tobytes()


def test_late_shapes_are_in_the_status_of_a_tick(tmp_path):
    """A thread that makes 10,000 steps in a period of 10 ms never keeps it."""
    scene = soft_cube(tmp_path, SCENE.format(thread="own").replace("10 ms", "10 ms, step: 1e-6"))
    with palpate.Session(scene) as session:
        session.start()
        end = time.monotonic() + 20.0
        while not (late := int(session.latest()["status"]) & bench.LATE) and time.monotonic() < end:
            time.sleep(0.02)
    assert late


def test_scene_refuses_a_thread_that_does_not_exist(tmp_path):
    with pytest.raises(SceneError, match="thread"):
        soft_cube(tmp_path, SCENE.format(thread="other"))


def test_status_has_words_for_soft_bodies():
    words = {name: (bit, text) for name, bit, text in _core.status_words()}
    assert words["soft_late"][0] == bench.LATE
    assert "step" in words["soft_frozen"][1]

"""Two tools on one soft body: each feels the other, and their forces add up to the reaction of the held nodes."""

from __future__ import annotations

import numpy as np
import pytest
from loop_rig import HEIGHT, options, simulation

from palpate import Tissue, _core, _tissue
from palpate.record.ticks import as_ticks
from palpate.scene.contact import render
from palpate.scene.contact.rendering import snapshot_of
from palpate.world.tissue.blocks import block

R, DEPTH, AWAY, TICKS = 5e-3, 3e-3, 9e-3, 900  # the tools press at x = -AWAY and x = AWAY


@pytest.fixture(scope="module")
def slab():
    """A slab of 60 x 60 x 30 mm with its top at z = 0, held at its ground."""
    nodes, tets = block((6, 6, 3), (0.06, 0.06, 0.03))
    nodes = nodes - [0.03, 0.03, 0.03]
    return Tissue((nodes, tets), young=20e3, fixed=nodes[:, 2] < -0.0299, damping=20.0)


def pair(snapshot, x, depth):
    """A simulation whose tool presses at x [m] by a depth [m] from .1 to .4 s, and holds."""
    X_WB = options().X_WB
    X_WB[:3, 3] += [x, 0.0, R]
    z = [HEIGHT + R, R - depth] if depth > 0.0 else [HEIGHT + R, HEIGHT + R]
    path = _core.HandPath([0.1, 0.4], np.array([[x, 0.0, h] for h in z]))
    return simulation(snapshot, path, X_WB=X_WB, contact__radius=R, hand__stiffness=2000.0)


def run(slab, depths=(DEPTH, DEPTH), shared=True):
    """Ticks of both tools, and the snapshot."""
    world = snapshot_of(slab.core, stiffness=0.0)
    world = _tissue.share_bodies(world) if shared else world
    both = [pair(world, x, depth) for x, depth in zip((-AWAY, AWAY), depths, strict=True)]
    return [as_ticks(rows) for rows in _core.run_in_turns(both, TICKS)], world


@pytest.fixture(scope="module")
def pressed(slab):
    return run(slab)


def up(ticks):
    """Mean vertical force on the tool at the end [N]."""
    return float(ticks["F_T_W"][-50:, 2].mean())


def test_symmetric_places_feel_alike(pressed):
    (left, right), _ = pressed
    assert up(left) > 0.1
    assert up(left) == pytest.approx(up(right), rel=0.03)
    assert left["F_T_W"][-50:, 0].mean() == pytest.approx(-right["F_T_W"][-50:, 0].mean(), abs=0.05 * up(left))


def test_each_tool_feels_the_dent_of_the_other(slab, pressed):
    (left, _), _ = pressed
    (alone, idle), _ = run(slab, (DEPTH, 0.0))
    (apart, _), _ = run(slab, shared=False)
    assert not idle["F_T_W"].any()
    assert up(alone) == pytest.approx(up(apart), rel=1e-3), "control: separate bodies do not feel each other"
    assert up(left) < 0.97 * up(alone), "the surface has sunk beside the other tool"


def test_both_forces_are_those_of_two_spheres_in_one_loop(slab, pressed):
    """Second algorithm: one loop with one tool of two spheres, on the measured positions."""
    (left, right), _ = pressed
    apart = right["p_WT"] - left["p_WT"]
    assert np.ptp(apart, axis=0).max() < 2e-5, "both move alike"
    one = render(slab, left["p_WT"], radius=R, spheres=[(apart[-1], R)]).force
    both = left["F_T_W"] + right["F_T_W"]
    np.testing.assert_allclose(both[-300:, 2], one[-300:, 2], rtol=0.01)
    pressing = (left["t"] > 0.2) & (left["t"] < 0.4)
    assert np.abs(both[pressing, 2] - one[pressing, 2]).max() < 0.02 * one[:, 2].max(), "a tick of delay"


def test_forces_are_the_reaction_of_the_held_nodes(slab, pressed):
    (left, right), world = pressed
    u = world.objects[0].surface.displacements()
    body = slab.body
    body.set_state(slab.nodes + u, np.zeros_like(u))
    reaction = body.internal_forces()[slab.nodes[:, 2] < -0.0299].sum(axis=0)
    body.reset()
    forces = left["F_T_W"][-1] + right["F_T_W"][-1]
    np.testing.assert_allclose(np.abs(reaction), np.abs(forces), atol=0.01 * np.abs(forces).max())


def test_lockstep_repeats_its_bytes(slab, pressed):
    again, _ = run(slab)
    for one, other in zip(pressed[0], again, strict=True):
        names = [n for n in one.dtype.names if n not in ("cycle_us", "lateness_us")]
        assert all(one[n].tobytes() == other[n].tobytes() for n in names)


def test_body_comes_back_to_rest_for_new_loops(slab):
    world = _tissue.share_bodies(snapshot_of(slab.core, stiffness=0.0))
    loops = [pair(world, -AWAY, DEPTH)]
    first = as_ticks(loops.pop().run(TICKS))
    assert np.abs(world.objects[0].surface.displacements()).max() > 1e-4, "control: the body is still dented"
    second = as_ticks(pair(world, -AWAY, DEPTH).run(TICKS))
    assert (second["F_T_W"] == first["F_T_W"]).all()


def test_too_many_loops_are_refused(slab):
    world = _tissue.share_bodies(snapshot_of(slab.core, stiffness=0.0))
    loops = [pair(world, 0.0, 0.0) for _ in range(8)]
    with pytest.raises(RuntimeError, match="at most 8 pairs"):
        pair(world, 0.0, 0.0)
    assert len(loops) == 8

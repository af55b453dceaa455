"""The guard of soft bodies against divergence: told, without force, left by itself; and what it must not catch."""

from __future__ import annotations

import numpy as np
import pytest
from soft_bodies import lockstep, soft_cube

import palpate
from palpate.scene.contact import render
from palpate.world.tissue.blocks import block
from palpate_lab.verify.bench.tissue import threads as bench

R, UP, DEPTH = bench.RADIUS, np.array([0.0, 0.0, 1.0]), 2e-3


def press(surface, ticks, depth=DEPTH):
    """Forces (n,) and states of a sphere that rests below the plane z = 0."""
    forces, states = [], []
    for _ in range(ticks):
        forces.append(surface.respond(np.zeros(3), UP, depth, R))
        surface.advance(np.zeros(3), UP, depth, R, forces[-1] * UP)
        states.append(surface.state())
    return np.array(forces), states


@pytest.mark.parametrize("thread", ["cycle", "own"])
@pytest.mark.parametrize("broken", [np.nan, np.inf, 1e30])
def test_numbers_that_are_not_finite_freeze_the_body_and_the_guard_is_left_by_itself(thread, broken):
    surface = bench.slab(5e3, thread, 4e-3).core.own()
    before, _ = press(surface, 300)
    nodes = len(block((6, 6, 3), (1.0, 1.0, 1.0))[0])
    state = np.zeros((nodes, 3))
    state[::2] = broken
    surface.set_state(state, np.zeros((nodes, 3)))
    during, told = press(surface, 60)
    assert np.isfinite(during).all()
    assert np.isfinite(surface.vertices).all()
    assert told[-1][3], "the state says that it is frozen"
    assert during[-1] < 0.6 * before[-1], "the force goes to zero"
    after, told = press(surface, 900)
    assert (after == 0.0).any()
    assert np.abs(np.diff(after)).max() < 0.1 * before[-1], "it returns by a ramp"
    assert not told[-1][3], "the guard is left"
    assert after[-1] == pytest.approx(before[-1], rel=0.05)


def test_a_jump_of_the_body_leads_to_more_steps_before_it_leads_to_a_freeze():
    surface = bench.slab(5e3, "cycle").core.own()
    nodes = len(block((6, 6, 3), (1.0, 1.0, 1.0))[0])
    frozen, hurried = [], []
    for speed in (0.1, 3.0, 60.0):  # [m/s]
        surface.set_state(np.zeros((nodes, 3)), np.full((nodes, 3), speed))
        _, told = press(surface, 1, depth=0.0)
        hurried.append(told[0][2])
        frozen.append(told[0][3])
    assert hurried == [False, True, True]
    assert frozen == [False, False, True]


def test_huge_ratios_of_moduli_need_mass_but_no_guard():
    nodes, tets = block((6, 6, 3), (0.06, 0.06, 0.03))
    centres = nodes[tets].mean(axis=1) - [0.03, 0.03, 0.0]
    young = np.where(np.linalg.norm(centres - [0.0, 0.0, 0.01], axis=1) < 8e-3, 5e9, 5e3)
    soft = bench.slab(young, "cycle", step=5e-4)
    assert soft.body.added_mass() > 10.0, "told by check"
    force = render(soft, bench.palpation(), radius=R).force
    assert np.isfinite(force).all()
    _, told = press(soft.core.own(), 500)
    assert not any(state[3] for state in told)


@pytest.mark.parametrize(("pushed", "kept"), [(2e-3, True), (15e-3, False)])
def test_a_body_with_an_inverted_tetrahedron_returns_to_rest_instead_of_standing_still(pushed, kept):
    """A node of the top is pushed in, by more than a cell through the tetrahedra below it, and then all nodes jump."""
    surface = bench.slab(5e3, "cycle").core.own()
    nodes = block((6, 6, 3), (0.06, 0.06, 0.03))[0]
    rest, u = surface.vertices.copy(), np.zeros_like(nodes)
    u[np.argmin(np.linalg.norm(nodes - [0.03, 0.03, 0.03], axis=1)), 2] = -pushed
    surface.set_state(u, np.zeros_like(nodes))
    _, told = press(surface, 1, depth=0.0)
    assert not told[0][3], "it does not diverge by itself"
    surface.set_state(u, np.full_like(nodes, 60.0))
    _, told = press(surface, 1, depth=0.0)
    assert told[0][3]
    assert (np.abs(surface.vertices - rest).max() > 0.1 * pushed) == kept


SCENE = """
objects:
  - name: cube
    box: {size: [0.06, 0.06, 0.04]}
    unit: m
    tissue: {volume: cube.vtk, springs: 1.0e+12}
contact: {radius: 0.006}
operator: {palpate: {approach: 0.3, press: 1.0, force: 0.25}}
"""
FROZEN = 1 << 32  # bit soft_frozen of the status


def test_divergence_is_in_the_status_of_a_tick(tmp_path):
    """Springs that are too stiff for the time step make the body diverge at the first touch."""
    ticks = lockstep(palpate.Session(soft_cube(tmp_path, SCENE)), 800)
    frozen = ticks["status"] & FROZEN != 0
    assert not frozen[:200].any(), "control: not before the touch"
    assert frozen.any()
    force = np.linalg.norm(ticks["F_T_W"], axis=1)
    assert np.isfinite(force).all()
    long = np.convolve(frozen, np.ones(120), "valid") == 120
    assert (force[119:][long] < 1e-9).any(), "the force goes to zero"

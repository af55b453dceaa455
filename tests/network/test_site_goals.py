"""Goals of the site: no jump in place, orientation and jaw, wherever the tool is found."""

import itertools

import numpy as np
import pytest

from palpate import _core, _network


def driven(site, X, jaw, ticks, X0, dt=1e-3, t0=0.0):
    """Goals of a site whose ideal instrument begins at X0, while an operator's end wants the pose X and this jaw."""
    peer, state, goals = _network.Peer(), _network.SiteInput(), []
    state.X = X0
    for k in range(ticks):
        state.t = t = t0 + dt * k
        out = _network.Datagram()
        out.X, out.jaw, out.flags = X, jaw, _network.FLAG_ENGAGED
        peer.stamp(out, t)
        site.receive(out, t)
        goal = site.step(state, dt)
        peer.receive(site.send(), t)
        peer.step(t)
        goals.append((goal.X, goal.jaw, goal.flags))
        state.X, state.jaw = goal.X, goal.jaw
    return goals


def turned(angle, x=0.0):
    X = np.eye(4)
    X[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    X[:3, 3] = x, 0.0, 0.1
    return X


def fastest(goals, dt=1e-3):
    """Largest angular speed of the goal [rad/s], speed of its jaw [rad/s], and speed [m/s], from tick to tick."""
    pairs = list(itertools.pairwise(goals))
    turns = [np.arccos(min(1.0, 0.5 * (np.trace(a[0][:3, :3].T @ b[0][:3, :3]) - 1.0))) for a, b in pairs]
    moves = [np.linalg.norm(b[0][:3, 3] - a[0][:3, 3]) for a, b in pairs]
    return max(turns) / dt, max(abs(b[1] - a[1]) for a, b in pairs) / dt, max(moves) / dt


def test_a_tool_turns_and_closes_to_the_operators_orientation_without_a_jump():
    options = _network.SiteOptions()
    site = _network.Site(options, _core.Snapshot([]))
    goals = driven(site, turned(2.0, 0.01), 1.0, 4000, turned(0.0))
    turn, jaw, speed = fastest(goals)
    assert turn <= options.turn + 1e-3
    assert jaw <= options.turn + 1e-6
    assert speed <= options.speed + 1e-6
    np.testing.assert_allclose(goals[-1][0], turned(2.0, 0.01), atol=1e-6)
    assert goals[-1][1] == pytest.approx(1.0)
    first = next(k for k, goal in enumerate(goals) if goal[2] & _network.FLAG_ALIGNED)
    assert np.arccos(0.5 * (np.trace(goals[first][0][:3, :3].T @ turned(2.0)[:3, :3]) - 1.0)) < 0.06


def test_a_tool_that_others_moved_begins_where_it_is():
    options = _network.SiteOptions()
    site = _network.Site(options, _core.Snapshot([]))
    driven(site, turned(0.0), 0.0, 1500, turned(0.0))
    site.rest()
    goals = driven(site, turned(0.0), 0.0, 3000, turned(1.0, 0.05), t0=1.5)
    assert np.abs(goals[0][0] - turned(1.0, 0.05)).max() < 2e-3
    aligned = next(k for k, goal in enumerate(goals) if goal[2] & _network.FLAG_ALIGNED)
    assert fastest(goals[:aligned])[2] <= options.catch_up + 1e-6  # as before the first alignment
    assert fastest(goals)[2] <= options.speed + 1e-6
    np.testing.assert_allclose(goals[-1][0], turned(0.0), atol=1e-3)


def carried(site, t0, ticks=200, step=2.5e-4):
    """Moves the tool of a site along a force of 1 N; returns the energies of its port [J]."""
    state, X = _network.SiteInput(), np.eye(4)
    state.F = np.array([0.0, 0.0, 1.0])
    for k in range(ticks):
        X[2, 3] = step * k
        state.t, state.X = t0 + 1e-3 * k, X
        site.step(state, 1e-3)
    return site.send().energy_in + site.send().energy_out


def test_a_new_operator_finds_no_energy_of_the_one_before():
    """In mode `passivity` the hand may be given what this port has taken."""
    site = _network.Site(_network.SiteOptions(), _core.Snapshot([]))
    assert carried(site, 0.0) == pytest.approx(0.05, rel=0.01)
    site.forget_operator()
    assert carried(site, 1.0, ticks=1) == 0.0


def test_the_way_that_others_carry_the_tool_is_no_work_of_its_force():
    site = _network.Site(_network.SiteOptions(), _core.Snapshot([]))
    before = carried(site, 0.0)
    site.rest()  # at 50 mm; it is found at 0
    assert carried(site, 1.0, ticks=1) == before

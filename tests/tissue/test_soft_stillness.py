"""Contacts that are large beside the elements, and deep: at rest the force rests, and no motion makes it jump."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from palpate import Tissue
from palpate.scene.contact import render
from palpate.world.tissue.blocks import block
from palpate_lab.verify.bench import tissue as bench
from palpate_lab.verify.bench.tissue import stillness
from palpate_lab.verify.bench.tissue.bodies import Lab, chatter

R = 5e-3


def layer(cells, thickness, **values):
    """A layer of cubic cells with its top at z = 0, twice as wide as thick, held at its ground."""
    cell = thickness / cells
    nodes, tets = block((2 * cells, 2 * cells, cells), (2 * thickness, 2 * thickness, thickness))
    nodes = nodes - [thickness, thickness, thickness]
    return Tissue((nodes, tets), **{"young": 8e3, "fixed": nodes[:, 2] < -thickness + 0.01 * cell, **values})


def beyond_the_motion(force):
    """Largest second difference of a force (n, 3): what it changes in a tick beyond a motion that goes on [N]."""
    return np.linalg.norm(np.diff(force, n=2, axis=0), axis=1).max()


@pytest.mark.parametrize(
    ("cells", "depth", "values"),
    [
        (4, 0.9, {}),
        (6, 1.2, {"prony": ((0.5, 0.01), (0.3, 0.1))}),
        (5, 2.3, {"young": 3e3}),
        (6, 0.8, {"young": 70e3, "yeoh": 1.0}),
        (5, 1.1, {"thread": "own", "period": 12e-3}),
        (4, 0.9, {"thread": "own", "period": 20e-3}),
    ],
)
def test_a_held_tool_feels_a_constant_force_and_a_led_one_no_jumps(cells, depth, values):
    """The sphere spans 1.25 to 2 cells."""
    soft = layer(cells, 3.5 * R if depth > 1.5 else 3.0 * R, **values)
    s = np.linspace(0.0, 1.0, 300)
    rise = np.concatenate([s * s * (3.0 - 2.0 * s), np.ones(1100)])
    angle = np.concatenate([np.zeros(900), 2.0 * np.pi * rise[:300], np.full(200, 2.0 * np.pi)])
    tips = np.stack([2e-3 * np.sin(angle), 2e-3 * (1 - np.cos(angle)), R + 5e-4 - (depth * R + 5e-4) * rise], axis=1)
    force = render(soft, tips, radius=R, friction=0.2, static_friction=0.6).force
    first, last = chatter(force[450:600]), chatter(force[750:900])
    assert last < 5e-3
    assert last < max(0.6 * first, 5e-4), "what swings without viscosity decays"
    assert beyond_the_motion(force) < 0.05
    assert np.linalg.norm(force[899]) > 0.1, "control: it presses"


@pytest.mark.parametrize("period", [3e-3, 4e-3, 5e-3])
def test_a_swing_of_a_stiff_body_on_a_thread_dies_out_under_a_tool_that_sticks(period):
    """At 95 Hz. Forces whose directions are those at the beginning of a period feed it: it grew to 175 mN in 8 s."""
    soft = stillness.body(Lab(), 0.67, 1.0, period, {"young": 100e3, "poisson": 0.45})
    path = stillness.path(0.67, 1.0)
    tips = np.concatenate([path[: stillness.DOWN], np.repeat(path[stillness.DOWN : stillness.DOWN + 1], 2400, axis=0)])
    force = render(soft, tips, radius=stillness.RADIUS, friction=0.2, static_friction=0.6).force
    first, last = chatter(force[800:1100]), chatter(force[-300:])
    assert first > 1e-4, "control: it swings"
    assert last < 0.1 * first


def test_two_tools_in_one_dent_rest():
    soft = layer(6, 3.0 * R)
    tips = bench.pressed(R, 0.9 * R, (-0.6 * R, 0.2e-3), 0.3, 0.5)
    force = render(soft, tips, radius=R, spheres=[((1.3 * R, 0.0, 0.0), R)]).force
    assert chatter(force[-250:]) < 5e-3


def test_a_fold_between_jaws_larger_than_the_cells_rests():
    """Two spheres of 1.5 cells are pushed over a fold of four cells, which is wider than the gap between them."""
    cell = R / 1.5
    nodes, tets = block((4, 8, 6), (4 * cell, 8 * cell, 6 * cell))
    nodes = nodes - [2 * cell, 4 * cell, 6 * cell]
    soft = Tissue((nodes, tets), young=6e3, prony=((0.5, 1e-3),), fixed=nodes[:, 2] < -6 * cell + 1e-6)
    apart = 4 * cell + 2 * R - 0.7 * R
    s = np.linspace(0.0, 1.0, 600)
    z = R + 1e-3 - (2.3 * R + 1e-3) * np.concatenate([s * s * (3.0 - 2.0 * s), np.ones(500)])
    tips = np.stack([np.full_like(z, -0.5 * apart), np.full_like(z, 0.3e-3), z], axis=1)
    out = render(soft, tips, radius=R, friction=0.3, static_friction=0.4, spheres=[((apart, 0.0, 0.0), R)])
    assert chatter(out.force[-250:]) < 5e-3
    assert np.linalg.norm(np.diff(out.force, n=2, axis=0), axis=1).max() < 0.05


def test_a_flat_surface_is_as_deep_as_the_sphere_in_it_wherever_its_nodes_lie():
    """At rest, on cells from a quarter to seven times the radius."""
    for cells, radius in ((2, 1.5e-3), (4, 2e-3), (8, 3e-3), (8, 8e-3)):
        own = layer(cells, 0.02, thread="own").core.own()  # the half-space alone: no shape of the body yet
        for x in (0.0, 0.31e-3, 1.1e-3):
            for depth in (0.1 * radius, 0.6 * radius, 2.0 * radius):
                found = own.near_field(np.array([x, 0.4 * x, 0.0]), np.array([0.0, 0.0, 1.0]), depth, radius)[0]
                y = depth / radius
                plane = 8e3 / (1.0 - 0.45**2)
                series = 1.0 - 0.1 * y - y**2 / 840 + 11 * y**3 / 15120
                if y > 1.0:
                    continue
                assert found == pytest.approx(4 / 3 * plane * radius**2 * y**1.5 * series, rel=0.02), (cells, radius, x)


def chattering(*args, **how):
    """A rendering whose force chatters by half of itself from tick to tick."""
    out = render(*args, **how)
    return replace(out, force=out.force * (1.0 + 0.5 * (-1.0) ** np.arange(len(out.force)))[:, None])


def test_a_force_that_chatters_is_not_averaged():
    soft = layer(3, 0.02)
    assert Lab().steady(soft, R, 2e-3) > 0.0
    assert np.isnan(Lab(touch=chattering).steady(soft, R, 2e-3))


def test_the_figure_meets_its_limits_and_rejects_chatter_and_jumps():
    right = stillness.measure(Lab(), short=True).rows
    assert all(row["met"] for row in right), right
    assert not any(row["met"] for row in stillness.measure(Lab(touch=chattering), short=True).rows)

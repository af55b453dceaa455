"""Contact with soft bodies: force on a layer, relaxation, energy, friction, robustness."""

from __future__ import annotations

import numpy as np
import pytest

from palpate import Tissue
from palpate.base.errors import SurfaceError
from palpate.scene.contact import render
from palpate.world.tissue import indentation, viscosity
from palpate.world.tissue.blocks import block
from palpate_lab.verify.bench import tissue as bench

R = 5e-3
PRONY = [(0.5, 0.03), (0.3, 0.15), (0.2, 1.0)]


def slab(**material):
    """A slab of 60 x 60 x 30 mm, fixed at its ground, with its top at z = 0."""
    nodes, tets = block((6, 6, 3), (0.06, 0.06, 0.03))
    nodes = nodes - [0.03, 0.03, 0.03]
    return Tissue((nodes, tets), **{"young": 5000.0, "fixed": nodes[:, 2] < -0.0299, **material})


def test_layer_feels_as_its_closed_form_wherever_a_node_lies():
    """Four elements through the layer; the whole grid is ``palpate bench tissue``."""
    cases = bench.layer_cases([(R, 0.02, 5e-3)], places=2, depths=(0.25,))
    assert len(cases) == 1
    for case in cases:
        assert case["force"] == pytest.approx(case["expected"], rel=0.05)
        assert case["ripple"] < 0.01
        bare = float(indentation.hertz(R, case["depth"], bench.YOUNG, bench.POISSON))
        assert abs(bare / case["expected"] - 1.0) > 0.05, "control: the layer matters"


def test_force_is_quiet_at_rest_and_the_body_returns():
    soft = slab(damping=20.0)
    down = bench.pressed(R, 3e-3, (0.002, 0.001), 0.3, 0.6)
    tips = np.concatenate([down, down[::-1], np.repeat(down[:1], 600, axis=0), down])
    force = render(soft, tips, radius=R).force[:, 2]
    n = len(down)
    assert np.ptp(force[n - 100 : n]) < 0.01
    assert (force[2 * n : 2 * n + 600] == 0.0).all(), "exactly zero without contact"
    assert force[-1] == pytest.approx(force[n - 1], rel=0.01)
    assert np.abs(np.diff(force)).max() < 0.03


def test_relaxation_at_hold_follows_the_prony_series():
    soft = slab(prony=PRONY, damping=20.0)
    tips = bench.pressed(R, 2e-3, (0.0, 0.0), 0.05, 1.5)
    force = render(soft, tips, radius=R).force[:, 2]
    rest = render(slab(damping=20.0), tips, radius=R).force[-1, 2]
    t = np.arange(len(tips)) * bench.TICK
    elastic = rest * (np.maximum(R - tips[:, 2], 0.0) / 2e-3) ** 1.5
    expected = viscosity.hereditary_force(PRONY, t, elastic)
    held = t > 0.15
    np.testing.assert_allclose(force[held], expected[held], rtol=0.03)
    assert force[60] > 1.3 * force[-1], "control: it relaxes"


@pytest.mark.parametrize("young", [5e3, 60e3])
def test_tool_never_gets_energy_from_the_tissue(young):
    soft = slab(young=young, prony=PRONY)
    t = np.arange(1500) * bench.TICK
    tips = np.stack([0.004 * np.sin(17 * t), 0.003 * np.sin(11 * t), R - 2e-3 * (1 - np.cos(23 * t))], axis=1)
    out = render(soft, tips, radius=R, friction=0.3)
    taken = -np.concatenate([[0.0], np.cumsum((out.force[:-1] * np.diff(tips, axis=0)).sum(axis=1))])
    assert taken.min() > -0.5e-3
    assert taken.max() > 1e-4, "control: the tool works on the tissue"
    assert (out.force @ [0, 0, 1] >= 0).all()


def test_friction_holds_and_slips_while_the_surface_moves():
    soft = slab(damping=20.0)
    down = bench.pressed(R, 3e-3, (-0.01, 0.0), 0.2, 0.2)
    slide = np.repeat(down[-1:], 600, axis=0)
    slide[:, 0] += np.linspace(0.0, 0.02, 600)
    force = {mu: render(soft, np.concatenate([down, slide]), radius=R, friction=mu).force for mu in (0.0, 0.4)}
    assert np.abs(force[0.0][-200:, 0]).max() < 0.15 * force[0.0][-1, 2], "without friction only the slope of the dent"
    ratio = -force[0.4][-200:, 0] / force[0.4][-200:, 2]
    assert ratio.mean() == pytest.approx(0.4, abs=0.1)
    early = -force[0.4][len(down) + 10, 0]
    assert 0.0 < early < 0.3 * force[0.4][-1, 2], "it sticks first"


def test_random_pokes_stay_finite_and_leave_no_inversion():
    soft = slab(prony=PRONY[:1])
    rng = np.random.default_rng(4)
    tips = []
    for _ in range(25):
        x, y = rng.uniform(-0.02, 0.02, 2)
        depth, speed = rng.uniform(0.0, 0.012), rng.uniform(0.05, 1.0)
        s = np.sin(np.linspace(0.0, np.pi, max(20, int(2000 * 0.02 / (speed * 1.0)))))
        drag = rng.uniform(-0.01, 0.01, 2)
        z = R + 0.003 - s * (depth + 0.003)
        tips.append(np.stack([x + drag[0] * s, y + drag[1] * s, z], axis=1))
    tips = np.concatenate(tips)
    out = render(soft, tips, radius=R, friction=0.5)
    assert np.isfinite(out.force).all()
    assert np.linalg.norm(out.force, axis=1).max() < 20.0
    assert (out.normal[out.depth > 0] @ [0, 0, 1] > 0.0).all(), "no pop-through"


def test_body_survives_a_tool_that_jumps_through_it():
    """Jumps of several elements in a tick throw the body out of its range; the guard returns it to a usable state."""
    soft = slab(young=800.0, yeoh=5.0)
    wild = np.random.default_rng(5).uniform([-0.02, -0.02, -0.025], [0.02, 0.02, 0.02], (300, 3))
    away = np.tile([0.0, 0.0, 0.05], (900, 1))
    calm = bench.pressed(R, 2e-3, (0.0, 0.0), 0.2, 0.2)
    force = render(soft, np.concatenate([wild, away, calm]), radius=R, friction=0.5).force
    assert np.isfinite(force).all()
    assert np.linalg.norm(force[:300], axis=1).max() > 0.5, "control: the jumps hit it hard"
    expected = render(soft, calm, radius=R).force[-1, 2]
    assert force[-1, 2] == pytest.approx(expected, rel=0.08), "it works again"


def test_renderings_repeat_their_bytes_and_start_from_rest():
    soft = slab(prony=PRONY)
    tips = bench.pressed(R, 4e-3, (0.0, 0.0), 0.1, 0.1)
    first, second = (render(soft, tips, radius=R).force.tobytes() for _ in range(2))
    assert first == second


def test_penalty_method_and_further_spheres_touch_it_too():
    soft = slab(damping=20.0)
    tips = bench.pressed(R, 2e-3, (0.0, 0.0))
    proxy, penalty = (render(soft, tips, radius=R, method=m).force[-1, 2] for m in ("proxy", "penalty"))
    assert penalty == pytest.approx(proxy, rel=0.03)
    two = render(soft, tips, radius=R, spheres=[([0.015, 0.0, 0.0], R)]).force[-1, 2]
    assert 1.4 * proxy < two < 2.0 * proxy, "each sphere sinks into the dent of the other"
    with pytest.raises(ValueError, match="soft"):
        render(soft, tips, radius=R, method="paper-alg1")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"poisson": 0.5}, "poisson = 0.5"),
        ({"young": -1.0}, "young = -1"),
        ({"density": 0.0}, "density"),
        ({"young": np.ones(3)}, "one number or"),
        ({"fixed": [10_000]}, "fixed"),
        ({"prony": [(0.1, -1.0)]}, "tau"),
    ],
)
def test_invalid_tissue_is_refused_with_the_value(change, message):
    with pytest.raises(SurfaceError, match=message):
        slab(**change)


def test_stiffness_belongs_to_rigid_surfaces_only():
    with pytest.raises(ValueError, match="material of a Tissue"):
        render(slab(), np.zeros((1, 3)), radius=R, stiffness=500.0)
    with pytest.raises(ValueError, match="stiffness is missing"):
        render(slab().core, np.zeros((1, 3)), radius=R)

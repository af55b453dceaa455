"""The passivity study: its energy measure, its closed-form bound, and some of its runs."""

import json

import numpy as np
import pytest

from palpate import _core
from palpate.studies.passivity import work as passivity


@pytest.fixture(scope="module")
def found():
    return [passivity.experiment({"run": k}, seed) for k, seed in enumerate(range(100, 160))]


def test_port_is_passive_and_nothing_diverges(found):
    summed = passivity.summed_up(found)
    off, *layers = summed["modes"]
    assert off["below_bound"] > 3  # control: the layer has something to prevent
    for layer in layers:
        assert layer["below_bound"] == layer["diverged"] == layer["oscillates"] == 0
        assert layer["lowest_port_J"] >= -passivity.BOUND
    assert layers[-1]["mode"] == "alone"
    assert layers[-1]["rendered_below_bound"] == 0
    json.dumps(summed)


def test_layer_does_not_act_below_the_closed_form_bound(found):
    silent = [f for f in found if f["silent"]]
    assert len(silent) >= 3
    for f in silent:
        assert f["observer"]["change"] < passivity.CHANGED


def test_energy_measure_agrees_with_friction_losses():
    """A block with only dry friction: all energy of the hand is dissipated, and the measure is a lower bound."""
    one = passivity.case(7)
    axis = one.axis
    axis.K, axis.B, axis.damping, axis.coulomb = 0.0, 0.0, 0.0, 0.3
    _, rows = passivity.Case(axis, one.path).run("off")
    rendered, whole = passivity.port(axis, rows)
    assert not rendered.any()
    assert whole[-1] == pytest.approx(0.3 * np.abs(np.diff(rows[:, 1])).sum())


def test_same_seed_gives_the_same_case():
    a, b, c = (passivity.case(seed) for seed in (5, 5, 6))
    assert (a.axis.K, a.path) == (b.axis.K, b.path)
    assert a.axis.K != c.axis.K


@pytest.mark.parametrize(("delay", "least", "most"), [(0.0, 206, 209), (0.010, 134, 137), (0.050, 4, 8)])
def test_largest_stiffness_without_intervention(delay, least, most):
    """The table of docs/stability-passivity.md: an MTM released at 5 cm/s and 3 N."""
    o = _core.StabilityOptions()
    o.delay, o.acceleration = delay, 9.0
    assert passivity.pays(least, o, 3.0, 0.05)
    assert not passivity.pays(most, o, 3.0, 0.05)


@pytest.mark.parametrize(
    ("changed", "acts"),
    [({}, False), ({"rate_cap": 14.9}, True), ({"force_cap": 0.49}, True), ({"damping": 0.0, "B": 0.0}, True)],
)
def test_layer_never_acts_on_a_passive_wall_within_its_caps(changed, acts):
    """100 N/m times 5 cm/s are 5 N/s; the damper's force of 5 mN may change its sign in a tick: 10 N/s more."""
    axis, o = _core.AxisOptions(), _core.StabilityOptions()
    axis.K, axis.B, axis.damping, axis.rate, axis.delay = 100.0, 0.1, 0.0, 1000.0, 0.0
    o.force_cap, o.rate_cap, o.allowance = 2.0, 15.1, 1.0
    for name, value in changed.items():
        setattr(axis if hasattr(axis, name) else o, name, value)
    assert passivity.silent(axis, o, 0.5, 0.05) != acts


def test_a_wall_is_passive_from_the_closed_form_bound_on():
    """Colgate and Schenkel 1997, with half of the friction: 0.5 b + B >= K (T / 2 + delay)."""
    axis = _core.AxisOptions()
    axis.damping, axis.B, axis.rate, axis.delay = 0.6, 0.2, 500.0, 0.004  # 0.5 N s/m over 5 ms
    for K, passive in ((99.9, True), (100.1, False)):
        axis.K = K
        assert passivity.passive(axis) == passive

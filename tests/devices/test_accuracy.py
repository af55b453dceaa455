"""The accuracy of a device's force by a weight and by a spring, judged with devices of known gain."""

import numpy as np
import pytest

from palpate.base.errors import DeviceError
from palpate.devices import accuracy
from palpate.devices.simulated import SimulatedDevice, Truth


def asked(words, log=None):
    if log is not None:
        log.append(words)


@pytest.mark.parametrize("gain", [0.8, 1.1])
def test_a_weight_and_a_spring_recover_the_gain_of_a_device_in_spite_of_its_friction(gain):
    truth = Truth(force_gain=gain, friction=0.08, damping=1.0)
    log = []
    by_weight = accuracy.by_weight(SimulatedDevice(truth=truth), "it", 0.1, log.append)
    by_spring = accuracy.by_spring(SimulatedDevice(truth=truth), "it", 300.0, log.append)
    free = [f"take everything off the handle, which moves up and down by 8 mm with up to {F} N" for F in (2.1, 2.4)]
    assert log == [free[0], "hang the weight of 100 g on the handle",
                   free[1], "fasten the spring of 300 N/m to the handle, relaxed, along the vertical"]  # fmt: skip
    for found in (by_weight, by_spring):
        assert found.gain == pytest.approx(gain, abs=0.01)
        assert abs(found.gain - gain) < max(2.0 * found.reach, 0.004)
        assert found.friction_N == pytest.approx(0.08 / gain, rel=0.25)
    assert {0.8: "too weak", 1.1: "too strong"}[gain] in by_weight.in_words()


def test_the_interval_of_a_spring_covers_what_settling_adds():
    """Devices that differ in friction and mass; the scatter between the cycles alone was a tenth of the error."""
    for seed, (friction, mass) in enumerate([(0.03, 0.15), (0.13, 0.35)]):
        truth = Truth(friction=friction, mass=mass, seed=seed)
        found = accuracy.by_spring(SimulatedDevice(truth=truth), "it", 300.0, asked)
        assert abs(found.gain - 1.0) <= found.reach < 0.03
        assert "true within the interval" in found.in_words()


def test_a_device_with_a_spring_of_its_own_is_compared_with_itself():
    found = accuracy.by_spring(SimulatedDevice(truth=Truth(stiffness=40.0)), "it", 200.0, asked)
    assert found.gain == pytest.approx(1.0, abs=0.01)


def test_one_device_is_compared_with_a_weight_and_then_with_a_spring():
    """The weight still hung on the simulated device: its force was 51,201 % of what was commanded."""
    device = SimulatedDevice(truth=Truth())
    assert accuracy.by_weight(device, "it", 0.1, asked).gain == pytest.approx(1.0, abs=0.01)
    assert accuracy.by_spring(device, "it", 200.0, asked).gain == pytest.approx(1.0, abs=0.01)


class Table(SimulatedDevice):
    """The weight rests on a table in the lower third of the way."""

    _mass = 0.0
    load = property(
        lambda self: self._mass if self._p[2] > -1.3e-3 else 0.0, lambda self, mass: setattr(self, "_mass", mass)
    )


def test_a_weight_that_rests_on_a_table_in_a_part_of_the_way_is_doubted():
    """Its gain was printed as 114.5 +-0.9 % without a remark."""
    found = accuracy.by_weight(Table(truth=Truth()), "it", 0.15, asked)
    assert found.misfit > 0.06
    assert "doubted: the weight does not act everywhere" in found.in_words()
    fair = accuracy.by_weight(SimulatedDevice(truth=Truth()), "it", 0.15, asked)
    assert fair.misfit < 0.025
    assert fair.doubts == ()
    assert 3.0 <= fair.freedom <= 6.0


class Light(SimulatedDevice):
    """Somebody has hung on a fifth of the weight that is stated."""

    _mass = 0.0
    load = property(lambda self: 0.2 * self._mass, lambda self, mass: setattr(self, "_mass", mass))


def test_a_weight_that_is_another_one_is_refused():
    with pytest.raises(DeviceError, match=r"changes the force of the servo by 0\.59 N in place of 2\.9 N"):
        accuracy.by_weight(Light(truth=Truth()), "it", 0.3, asked)


def test_the_triangle_begins_in_the_middle_and_goes_from_end_to_end():
    t = np.linspace(0.0, 2.0 * accuracy.PERIOD, 4001)
    x = np.array([accuracy.wanted(one) for one in t])
    assert x[0] == 0.0
    assert (x.min(), x.max()) == pytest.approx((-0.5 * accuracy.STROKE, 0.5 * accuracy.STROKE), rel=1e-3)
    assert np.abs(np.diff(x)).max() == pytest.approx(
        accuracy.STROKE / (0.5 * accuracy.PERIOD) * (t[1] - t[0]), rel=1e-6
    )


class Beside(SimulatedDevice):
    """Its weight hangs elsewhere."""

    load = property(lambda self: 0.0, lambda self, mass: None)


class Stuck(SimulatedDevice):
    def _advance(self, F, dt, steps):
        return


class Unopened(SimulatedDevice):
    def open(self):
        raise AssertionError


@pytest.mark.parametrize(
    ("made", "act", "words"),
    [(SimulatedDevice, lambda d: accuracy.by_weight(d, "it", 2.0, asked), "needs up to"),
     (Unopened, lambda d: accuracy.by_weight(d, "it", float("nan"), asked), "a weight of nan kg is none"),
     (Unopened, lambda d: accuracy.by_weight(d, "it", -0.1, asked), "give a number above 0"),
     (Unopened, lambda d: accuracy.by_spring(d, "it", float("inf"), asked), "a spring of inf N/m is none"),
     (Stuck, lambda d: accuracy.by_weight(d, "it", 0.05, asked), "does not follow"),
     (Beside, lambda d: accuracy.by_weight(d, "it", 0.05, asked), "nothing to compare")],
)  # fmt: skip
def test_what_cannot_be_compared_is_said(made, act, words):
    with pytest.raises(DeviceError, match=words):
        act(made())

"""An identified arm in the observer: torques of its drives and springs are not taken for external ones."""

import moving
import numpy as np
import pytest

from palpate import _core
from palpate.arm import Arm
from palpate.arm.drives import drive_train
from palpate.arm.dynamics import Dynamics
from palpate.arm.identify.motion import RecordedMotion
from palpate.arm.identify.payload import external_torque
from palpate.arm.observer import drive_inertia, estimate_options
from palpate.base.errors import RecordingError

RATE = 200.0


def random_model(arm: Arm, at: str, only: tuple[str, ...] = ()) -> Dynamics:
    """A model with random terms, or with random terms `only`."""
    rng, train = np.random.default_rng(4), drive_train(arm, at)
    theta = [0.02 * rng.uniform() * (not only or t.name.rpartition("_")[0] in only) for t in train.terms]
    return Dynamics(arm, arm.inertial_parameters, np.array(theta), at)


@pytest.mark.parametrize(("arm", "at"), [(Arm.mtm("left"), "drives"), (Arm.psm(), "drives"), (Arm.psm(), "joints")])
def test_modelled_torques_are_no_external_torques(arm, at):
    d = random_model(arm, at)
    to_drives = np.linalg.pinv(d.train.coupling).T  # with the jaw at rest
    q, v, a = (x @ to_drives for x in moving.excitation(3, arm.home, np.full(arm.n, 0.05), 6.0))
    tau = d.torque(q, v, a)
    r = external_torque(d, RecordedMotion(q, v, a, tau, RATE, 0, "known"), bandwidth=5.0)
    largest = np.abs(tau @ np.linalg.pinv(d.train.coupling)).max(axis=0)
    assert (np.abs(r[200:]).max(axis=0) < 0.01 * largest + 1e-3).all()


def test_joint_options_describe_a_joint_that_moves_alone():
    """Each joint of a PSM moves at a constant speed through q = 0: torque of its drives in addition to the links."""
    arm = Arm.psm()
    d = random_model(arm, "drives", ("coulomb", "viscous", "offset", "joint_coulomb", "joint_viscous"))
    o = estimate_options(d)
    for j in range(arm.n):
        v = np.zeros((400, arm.n))
        v[:, j] = 0.1
        q = arm.home + np.cumsum(v, axis=0) / RATE
        to_drives = np.linalg.pinv(d.train.coupling).T
        s = d.train.state(q @ to_drives, v @ to_drives, 0.0 * v @ to_drives)
        at_joint = d.terms(s)[-1] @ np.linalg.pinv(d.train.coupling)
        assert at_joint[j] == pytest.approx(o.coulomb[j] + 0.1 * o.viscous[j] + o.offset[j], rel=1e-6)
    np.testing.assert_allclose(drive_inertia(random_model(arm, "drives", ("rotor",))).diagonal()[:4] > 0, True)


def test_platform_cable_is_rejected_in_the_cycle():
    with pytest.raises(RecordingError, match="cannot evaluate its term 'cable_4_1'"):
        estimate_options(random_model(Arm.mtm("left"), "drives"), _core.EstimateOptions())

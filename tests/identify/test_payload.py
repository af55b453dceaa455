"""Payload identification from drive torques: with a known simulated load, and with a real one."""

import os
from functools import cache
from pathlib import Path

import moving
import numpy as np
import pytest
from effort import LONG

from palpate.arm import Arm
from palpate.arm.drives import drive_train
from palpate.arm.dynamics import Dynamics
from palpate.arm.identify import payload
from palpate.arm.identify.motion import RecordedMotion, motion
from palpate.arm.identify.recordings import Moving
from palpate.base.errors import RecordingError
from palpate_lab.verify.coverage.estimates import payload as slipping

DATA = Path(os.environ.get("PALPATE_DATA", "../shared/data")) / "psm_moving"
ARM = Arm.psm()


@pytest.fixture(scope="module")
def known() -> Dynamics:
    return Dynamics(ARM, ARM.inertial_parameters, np.zeros(len(drive_train(ARM).terms)))


def excited() -> tuple[np.ndarray, ...]:
    return moving.excitation(7, np.array([-0.2, 0, 0.15, 0, 0, 0, 0]), np.array([0.5, 0.8, 0.07, 0.5, 0.3, 0.3, 0.3]))


@cache
def exact() -> RecordedMotion:
    """The motion without load and noise."""
    q, v, a = excited()
    model = Dynamics(ARM, ARM.inertial_parameters, np.zeros(len(drive_train(ARM).terms)))
    return motion(Moving(q, v, model.torque(q, v, a), 200.0, "exact"))


def with_torque(tau: np.ndarray, name: str) -> RecordedMotion:
    m = exact()
    return RecordedMotion(m.q, m.v, m.a, tau, m.rate, 0, name)


def unloaded(known: Dynamics, seed: int) -> RecordedMotion:
    tau = exact().tau
    return with_torque(tau + 2e-3 * np.random.default_rng(seed).normal(size=tau.shape), f"unloaded {seed}")


@cache
def axes(joint: int, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Axis of the bar and the pivot (k, 3) along the motion, with a joint moved by a step [rad]."""
    moved = excited()[0][:, :6] + step * np.eye(6)[joint]
    poses = [ARM.link_poses(row) for row in moved]
    pivot = [*payload.Hang().p_pivot, 0.0]
    return np.array([one["yaw_link"][:3, 0] for one in poses]), np.array(
        [one["pitch_link"][:3, :3] @ pivot for one in poses]
    )


@cache
def torque_of_a_kilogram(height: float) -> np.ndarray:
    """Torques (k, 2) [N m] of a body of 1 kg on the bar along the motion, by d'Alembert's principle."""

    def position(joint: int = 0, step: float = 0.0) -> np.ndarray:
        axis, pivot = axes(joint, step)
        return height * axis + pivot

    acceleration = np.gradient(np.gradient(position(), 1 / moving.RATE, axis=0), 1 / moving.RATE, axis=0)
    h, tau = 1e-6, np.zeros((len(acceleration), 2))
    for j in range(2):
        J = (position(j, h) - position(j, -h)) / (2 * h)
        tau[:, j] = (J * (acceleration - [0, 0, -9.81])).sum(axis=1)
    return tau


def with_load(known: Dynamics, mass: float, height: float, seed: int = 3) -> RecordedMotion:
    """The same motion with a body on the bar."""
    tau = unloaded(known, seed).tau
    tau[:, :2] += mass * torque_of_a_kilogram(height)
    return with_torque(tau, "loaded")


def test_known_body_on_the_bar_is_identified(known):
    load = payload.estimate_load(known, with_load(known, 0.2, 0.08), [unloaded(known, 1), unloaded(known, 2)])
    assert load.mass == pytest.approx(0.2, rel=0.03)
    assert min(load.explained) > 0.95
    np.testing.assert_allclose(load.tared, load.fitted, atol=0.02)


@pytest.mark.parametrize(("mass", "height"), [(0.12, 0.13), (0.4, -0.05)])
def test_load_far_from_the_pivot_is_exact_without_noise(known, mass, height):
    """The torque is quadratic in the place; `torque_of_a_kilogram` differentiates the path instead."""
    tau = exact().tau.copy()
    tau[:, :2] += mass * torque_of_a_kilogram(height)
    load = payload.estimate_load(known, with_torque(tau, "loaded"), [exact(), exact()])
    assert load.mass == pytest.approx(mass, rel=2e-3)
    assert load.place == pytest.approx((height, 0.0), rel=0.1, abs=1e-3)


def test_missing_load_explains_nothing(known):
    load = payload.estimate_load(known, unloaded(known, 3), [unloaded(known, 1), unloaded(known, 2)])
    assert max(load.explained) < 0.1


def test_missing_load_explains_nothing_where_friction_slips():
    """In the rows that it was fitted to, a load of these recordings without one explains 25 % of the yaw's variance."""
    rng, (_, q, v, a) = np.random.default_rng(77), slipping._motion()
    recordings = [RecordedMotion(q, v, a, slipping._recorded(rng), slipping._RATE, 0, "simulated") for _ in range(3)]
    load = payload.estimate_load(slipping._known()[0], recordings[0], recordings[1:])
    assert max(load.explained) < 0.1
    assert load.interval[0] < 0.0 < load.interval[1]


def test_missing_load_is_identified_as_zero(known):
    load = payload.estimate_load(known, unloaded(known, 3), [unloaded(known, 1), unloaded(known, 2)])
    assert load.mass == pytest.approx(0.0, abs=0.01)


def test_different_motions_and_a_single_tare_are_rejected(known):
    m = unloaded(known, 1)
    with pytest.raises(RecordingError, match="1 unloaded recording"):
        payload.estimate_load(known, m, [m])
    other = RecordedMotion(m.q + 0.1, m.v, m.a, m.tau, m.rate, 0, "other")
    with pytest.raises(RecordingError, match="a tare needs the same motion"):
        payload.estimate_load(known, m, [m, other])


def test_disturbance_in_one_recording_widens_the_interval_with_little_bias(known):
    """A cable pulls with 0.15 N m for 4 s of one recording, which is more than the body's torque.

    Six blocks and two tares determine a width within a third only, so the widths of several recordings are compared.
    """
    n, least = (12, 9) if LONG else (6, 4)  # at 0.95: fewer in one of four hundred
    clean, caught = [], []
    for seed in range(n):
        loaded = with_load(known, 0.1, 0.08, 3 * seed)
        one, two = unloaded(known, 3 * seed + 1), unloaded(known, 3 * seed + 2)
        clean.append(payload.estimate_load(known, loaded, [one, two]))
        tau = one.tau.copy()
        tau[1000:1800, 1] += 0.15
        caught.append(payload.estimate_load(known, loaded, [with_torque(tau, "caught"), two]))
    for found in (clean, caught):
        assert np.mean([load.mass for load in found]) == pytest.approx(0.1, rel=0.01)
        assert max(abs(load.mass - 0.1) for load in found) < 0.01
        covered = sum(load.interval[0] < 0.1 < load.interval[1] for load in found)
        assert covered >= least
    widths = [np.mean([np.ptp(load.interval) for load in found]) for found in (clean, caught)]
    assert widths[1] > widths[0]


@pytest.mark.skipif(not DATA.is_dir(), reason=f"no recordings in {DATA} (set PALPATE_DATA)")
def test_weight_on_the_real_arm_is_identified():
    from palpate_lab.studies.force.work import weight

    load = weight(DATA)
    assert load.mass == pytest.approx(0.105, rel=0.15)
    assert load.interval[0] < 0.105 < load.interval[1]

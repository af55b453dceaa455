"""Three real arms, trained on 160 poses and tested on 400 others: each joint is at least as good as published."""

import numpy as np
import pytest
from real_data import DATA, needs_data

from palpate.arm.identify.gravity import gravity

RMS = {"MTML_34863": [0.025, 0.045, 0.030, 0.029, 0.005, 0.004],
       "MTMR_31519": [0.030, 0.053, 0.039, 0.025, 0.007, 0.005],
       "MTMR_28247": [0.026, 0.059, 0.049, 0.052, 0.007, 0.004]}  # fmt: skip
R2 = {"MTML_34863": [0.74, 0.95, 0.96, 0.70, 0.88, 0.91],
      "MTMR_31519": [0.83, 0.93, 0.92, 0.77, 0.88, 0.90],
      "MTMR_28247": [0.52, 0.90, 0.86, 0.59, 0.84, 0.93]}  # fmt: skip


def learn(name, train, **options):
    files = [DATA / "mtm_static" / f"{name}__{part}.csv" for part in train.split()]
    test = DATA / "mtm_static" / f"{name}__random_N400.csv"
    return gravity(files, name[:4].lower(), test=test, **options)


@needs_data
@pytest.mark.parametrize("name", RMS)
def test_unseen_poses_of_real_arms_are_predicted(name):
    found = learn(name, "random_N160")
    assert (found.test.rms < np.add(RMS[name], 0.001)).all(), found.test.rms
    assert (found.test.r2 > np.subtract(R2[name], 0.01)).all(), found.test.r2
    assert (found.test.r2_directed[:3] > [0.83, 0.95, 0.945]).all(), "the order of rows gives the direction of approach"
    assert (found.test.coverage > 0.85).all()
    assert found.identifiability.rank == 10


@needs_data
def test_forty_poses_are_nearly_as_good():
    many, few = learn("MTML_34863", "random_N160"), learn("MTML_34863", "random_N40")
    assert (few.test.rms < 1.10 * many.test.rms).all(), few.test.rms / many.test.rms


@needs_data
def test_real_joint_stop_is_found():
    found = learn("MTMR_28247", "random_N160")
    assert [(s.joint, s.side) for s in found.model.stops] == [(3, -1)]
    assert found.model.stops[0].at == pytest.approx(-1.30, abs=0.02)
    assert np.abs(found.model.holding(found.poses.q, _right())[:, 3]).max() < 0.15, "the stop is not compensated"


@needs_data
def test_grids_reached_from_both_sides_give_the_friction():
    """Half differences of the +/- grids; values of .013/.042/.028 N m and less are published for such arms."""
    found = learn("MTMR_31519", "uniform_pos uniform_neg", model="gravity+springs")
    np.testing.assert_allclose(found.model.friction[1:3, 0], [0.042, 0.028], atol=0.002)
    assert found.test.r2[1] > 0.88


@needs_data
def test_impossible_torques_of_a_real_grid_are_outliers():
    found = learn("MTMR_28247", "uniform_pos")
    wild = [o for o in found.fitted.outliers if "three times" in o.why]
    assert len(wild) >= 13
    assert {o.joint for o in wild} == {4}


def _right():
    from palpate import Arm

    return Arm.mtm("right")

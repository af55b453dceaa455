"""The judge of a gravity model's stated deviation, on linear models of known truth and on arms of another form."""

import numpy as np
import pytest
import synthetic_arm

from palpate.arrays.intervals import proportion
from palpate.identify import fit_gravity, scores
from palpate.identify.scores import factor_of_deviation

JOINTS = tuple(range(6))


@pytest.mark.parametrize(("stated", "least"), [(1.0, 0.0), (3.0, 0.95), (0.02, 0.8)])
def test_deviations_that_are_three_times_too_large_or_missing_are_refuted(stated, least):
    """Parameters from 600 poses, judged on 600 others. The coverage of the band of a torque sees neither."""
    rng, out, right, band = np.random.default_rng(0), 0, 0, []
    for _ in range(60):
        A, B = rng.normal(size=(2, 600, 40))
        root = np.linalg.cholesky(np.linalg.inv(A.T @ A))
        error = B @ root @ rng.normal(size=40) + rng.normal(size=600)
        low, _, high = factor_of_deviation(error, stated * B @ root)
        out += not low <= 1.0 <= high
        right += low <= 1.0 / stated <= high
        band.append(np.mean(np.abs(error) < 1.96 * np.sqrt(1.0 + stated**2 * np.square(B @ root).sum(axis=1))))
    assert proportion(right / 60, 60)[1] >= 0.93
    assert out / 60 >= least
    assert 0.92 < np.mean(band) < 0.985
    if stated == 1.0:
        assert out <= 8


@pytest.mark.parametrize(("form", "told"), [("potential", False), ("gravity+springs", True)])
def test_band_of_a_form_that_is_not_that_of_the_arm_has_a_remark(form, told):
    """A torque that is no spring at joint 4, fitted in a third of its range as a spring, and judged in all of it."""
    arm, train, test = synthetic_arm.true_arm(), synthetic_arm.recording(300, 1), synthetic_arm.recording(150, 50)
    if told:
        for poses in (train, test):
            poses.tau[:, 3] += 0.05 * np.sin(4.0 * poses.q[:, 3])
        train = train.only(np.abs(train.q[:, 3] - 0.9) < 0.5)
    fitted = fit_gravity.fit_poses(train, arm, form, np.r_[np.ones(6, bool), False])
    found = scores.remarks(scores.score(fitted, test, JOINTS, arm), JOINTS, len(test), unseen=True)
    assert any(text.startswith("joint 4") and "another form" in text for text in found) == told

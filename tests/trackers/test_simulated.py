"""The simulated tracker: its noise against theory, its faults, and its repeatability."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from palpate.sensing.trackers.simulated import SPHERES, Fault, SimulatedTracker, fit


def still(p, turn_deg=0.0):
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = Rotation.from_euler("xyz", [turn_deg, 20, 30], degrees=True).as_matrix(), p
    return lambda t: X


TOOLS = {"a": still([0, 0, 1.5]), "b": still([0.2, 0, 1.4], 40.0)}


def test_exact_spheres_give_the_exact_pose():
    X = TOOLS["b"](0.0)
    fitted, error = fit(SPHERES @ X[:3, :3].T + X[:3, 3])
    assert fitted == pytest.approx(X, abs=1e-12)
    assert error < 1e-12


def test_distances_between_spheres_differ_so_that_none_can_be_confused():
    i, j = np.triu_indices(4, 1)
    d = np.sort(np.linalg.norm(SPHERES[i] - SPHERES[j], axis=1))
    assert np.diff(d).min() > 3e-3


def test_noise_of_the_pose_and_residual_are_those_of_least_squares():
    """First-order theory of rigid registration (Fitzpatrick 1998), for N spheres with noise s on each axis: the
    centroid has s / sqrt(N) on each axis, and the mean square residual is 3 s^2 (1 - 2 / N)."""
    s, tracker = 0.25e-3, SimulatedTracker({"a": TOOLS["a"]}, seed=3)
    seen = [tracker.frame(k)[0] for k in range(1500)]
    centroids = np.array([x.X[:3, :3] @ SPHERES.mean(axis=0) + x.X[:3, 3] for x in seen])
    assert centroids.std(axis=0) == pytest.approx(np.full(3, s / 2), rel=0.08)
    assert np.mean([x.error**2 for x in seen]) == pytest.approx(3 * s**2 * (1 - 2 / 4), rel=0.06)


def test_a_frame_is_a_pure_function_of_time_and_seed():
    def run(step, seed=1):
        tracker = SimulatedTracker(TOOLS, dropout=0.2, seed=seed)
        return [s for k in range(int(1.0 / step)) for s in tracker.poll((k + 1) * step)]

    one, other = run(0.01), run(0.25)
    assert [s.t for s in one] == [s.t for s in other]
    assert np.array_equal([s.X for s in one], [s.X for s in other])
    assert not np.array_equal(one[0].X, run(0.01, seed=2)[0].X)
    assert 0.15 < 1 - len(one) / 122 < 0.25


@pytest.mark.parametrize(
    ("kind", "gone"),
    [("occluded", {"a"}), ("stopped", {"a", "b"}), ("swapped-spheres", set()), ("swapped-tools", set())],
)
def test_faults_begin_and_end(kind, gone):
    tool = "" if kind in ("stopped", "swapped-tools") else "a"
    tracker = SimulatedTracker(TOOLS, rate=100.0, faults=[Fault(kind, 1.0, 2.0, tool)])
    before, during, after = ({s.tool: s for s in tracker.frame(k)} for k in (99, 150, 200))
    assert set(before) == set(after) == {"a", "b"}
    assert set(during) == {"a", "b"} - gone
    if kind == "swapped-spheres":
        assert during["a"].error > 10e-3 > 1e-3 > max(before["a"].error, during["b"].error)
    if kind == "swapped-tools":
        assert during["a"].X[0, 3] == pytest.approx(0.2, abs=2e-3)
        assert during["b"].X[0, 3] == pytest.approx(0.0, abs=2e-3)

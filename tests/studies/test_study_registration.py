"""`palpate study registration`: its keys, its references, and a short version of its figures."""

import json

import json_contract
import numpy as np
import pytest

from palpate.base.arrays import rigid
from palpate.base.arrays.plain import plain
from palpate.base.sweep import sweep
from palpate.world.registration import fit
from palpate.world.registration.clouds import sampled
from palpate.world.shapes.organs import gallbladder, organ
from palpate_lab.studies.registration import (
    chain,
    fiducials,
    figures,
    references,
    sessions,
    surfaces,
    views,
    words,
    work,
)


@pytest.fixture
def small(monkeypatch, tmp_path):
    """Coarse surfaces, few draws, no real data."""
    shapes = organ(2000), gallbladder(2000)
    models = sampled(*shapes[0], 8000), sampled(*shapes[0], 4000, seed=1), sampled(*shapes[1], 4000)
    monkeypatch.setattr(surfaces, "models", lambda: models)
    monkeypatch.setattr(surfaces, "KINDS", ("rough", "mirrored", "another"))
    monkeypatch.setattr(sessions, "KINDS", ("right", "mirrored"))  # another organ: tests/cli
    monkeypatch.setattr(fiducials, "_DRAWS", 30)
    monkeypatch.setenv("PALPATE_DATA", str(tmp_path))


def serial(fn, grid, seed, *, title, where=None):
    return sweep(fn, grid, seed, executor="serial", where=where)


def test_short_study(small, tmp_path):
    found = json.loads(json.dumps(plain(work.run(serial, 1, 2, 1, 1, 1, 1, 1)), allow_nan=False))
    assert set(found) == json_contract.keys("study registration")
    for part in ("predicted", "unknown", "wrong_marker", "surface", "handeye"):
        listed = json_contract.keys_of("study registration", f"`{part}`")
        assert all(set(row) <= listed for row in found[part].values()), part
    assert found["predicted"]["isotropic"]["largest_from_closed_form"] < 1e-3
    assert found["predicted"]["isotropic"]["largest_from_horn"] < 1e-9
    assert found["surface"]["rough"]["converged"] == 1.0
    assert found["wrong_told"] == 1.0
    assert set(found["touched"]) <= json_contract.keys_of("study registration", "`touched`")
    assert found["touched"]["simulated_m"] < 1.5e-3
    assert set(found["chain"]) <= json_contract.keys_of("study registration", "`chain`")
    assert all(
        set(row) <= json_contract.keys_of("study registration", "`session`") for row in found["session"].values()
    )
    assert found["session"]["right"]["right"] == 1.0
    assert found["session"]["mirrored"]["told"] == 1.0
    assert found["real"] is None
    assert "skipped" in words.line_of_real(found["real"])
    assert words.table(found).row_count > 10
    assert figures.draw(found, tmp_path).stat().st_size > 10_000


def test_horn_finds_the_pose_and_not_a_wrong_one():
    rng = np.random.default_rng(0)
    m, X = fiducials.layout(rng), fiducials.pose(rng)
    f = rigid.transform(X, m)
    assert references.horn(m, f) == pytest.approx(X, abs=1e-12)
    wrong = rigid.displaced(X, [0, 0, 0, 1e-3, 0, 0])
    assert np.abs(references.horn(m, f) - wrong).max() > 1e-4


def test_closed_form_of_fitzpatrick_agrees_with_simulation():
    """The judge itself: errors of Horn's poses at a target."""
    rng = np.random.default_rng(1)
    m, goal = fiducials.layout(rng), np.array([0.1, 0.05, 0.0])
    errors = [
        np.linalg.norm(rigid.transform(references.horn(m, m + 1e-4 * rng.normal(size=m.shape)), goal[None])[0] - goal)
        for _ in range(400)
    ]
    expected = references.fitzpatrick(m, 1e-4 * np.sqrt(3), goal)
    assert np.sqrt(np.mean(np.square(errors))) == pytest.approx(expected, rel=0.08)
    assert references.fitzpatrick(m, 1e-4 * np.sqrt(3), 2 * goal) > 1.2 * expected


def test_judge_notices_a_wrong_solver(monkeypatch):
    """A solver that forgets to remove the mean differs from Horn's."""
    monkeypatch.setattr(fiducials, "_DRAWS", 5)
    right = fit.solve
    assert fiducials.predicted({"anisotropic": 0}, 1)["from_horn"] < 1e-9
    monkeypatch.setattr(fit, "solve", lambda m, f, *S: right(m, f + 1e-4 * m, *S))
    assert fiducials.predicted({"anisotropic": 0}, 1)["from_horn"] > 1e-9


def test_one_hand_eye_calibration():
    found = views.judged({"mount": 0}, 1)
    assert found["position_m"] < 0.5e-3
    assert found["rotation_rad"] < np.radians(0.2)


def test_chain_is_as_exact_as_its_parts_and_shows_a_wrong_marker(monkeypatch):
    monkeypatch.setattr(surfaces, "models", lambda: models)
    models = sampled(*organ(2000), 8000), sampled(*organ(2000), 4000, seed=1), None
    chain._body.cache_clear()
    right = chain.judged({"trial": 0}, 3)
    assert right["tip_median_m"] < 1e-3
    assert right["felt_within"] > 0.8
    seen = chain._seen

    def bent(rng, X_KP):
        return (
            rigid.displaced(seen(rng, X_KP), [0.005, 0.0, 0.0, 0.0, 0.0, 0.0])
            if rng.random() < 0.5
            else seen(rng, X_KP)
        )

    monkeypatch.setattr(chain, "_seen", bent)
    assert chain.judged({"trial": 0}, 3)["tip_largest_m"] > 2e-3

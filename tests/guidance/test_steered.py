"""Changes of single fixtures during a session: switching, authority, motion."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from palpate import _guidance
from palpate.scene.guidance import Fixture
from palpate.scene.guidance.context import FixtureContext
from palpate.scene.guidance.steered import SteeredFixtures

BALL = Fixture.from_yaml("- {name: ball, role: forbid, geometry: {sphere: {radius: 0.02}}, law: {stiffness: 300}}")
LINE = Fixture.from_yaml("- {name: line, role: guide, geometry: {line: {start: [0, 0, 0.05], end: [0.1, 0, 0.05]}}}")


def steered():
    given = []
    return SteeredFixtures([BALL, LINE], FixtureContext(), lambda sections, core: given.append((sections, core))), given


def pose(p, rotvec=(0.0, 0.0, 0.0)):
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = Rotation.from_rotvec(rotvec).as_matrix(), p
    return X


def test_every_change_replaces_the_list_of_fixtures():
    fixtures, given = steered()
    fixtures.change("ball", enabled=False)
    fixtures.change("line", authority=0.25)
    sections, core = given[-1]
    assert len(given) == 2
    assert fixtures.names == ("ball", "line")
    assert [s.enabled for s in sections] == [False, True]
    assert [s.authority for s in sections] == [1.0, 0.25]
    assert len(core) == 2


def test_moved_fixture_agrees_with_its_section():
    """The moved geometry of the core gives the same results as a new one made from the section."""
    fixtures, _ = steered()
    X_W = pose([0.01, -0.02, 0.03], [0.3, -0.2, 0.9])
    fixtures.change("line", X_W=X_W)
    now = fixtures["line"]
    p = np.random.default_rng(1).uniform(-0.1, 0.1, (30, 3))
    X = np.tile(np.eye(4), (30, 1, 1))
    X[:, :3, 3] = p
    expected = now.section.make_geometry(FixtureContext()).query(X, np.zeros(30))
    carried = _guidance.PlacedGeometry(now.geometry, X_W).query(X, np.zeros(30))
    for key in ("distance", "point", "normal"):
        np.testing.assert_allclose(expected[key], carried[key], atol=1e-9, err_msg=key)


def test_dragging_a_fixture_gives_no_force_step():
    """A ball jumps around a resting hand: the force changes by at most 20 N/s."""
    stage = _guidance.Guidance()
    kept = []
    fixtures = SteeredFixtures([BALL], FixtureContext(), lambda _, core: (kept.append(core), stage.take(core)))
    fixtures.change("ball", authority=1.0)
    X, F = pose([0.0, 0.0, 0.015]), [np.zeros(6)]
    rng = np.random.default_rng(0)
    for k in range(3000):
        if k % 33 == 0 and k > 500:
            fixtures.change("ball", X_W=pose(rng.uniform(-0.005, 0.005, 3)))
        F.append(stage.step(1e-3 * k, X, np.zeros(6), X)["F_T_W"])
    steps = np.linalg.norm(np.diff(np.array(F)[:, :3], axis=0), axis=1)
    assert steps.max() <= 20.0 * 1e-3 * (1 + 1e-9)
    assert np.linalg.norm(F[500][:3]) == pytest.approx(1.5, rel=0.01), "control: the fixture pulled"


def test_invalid_changes_are_reported():
    fixtures, given = steered()
    with pytest.raises(KeyError, match="no fixture 'bell'; there are: ball, line"):
        fixtures.change("bell", enabled=True)
    with pytest.raises(ValueError, match=r"authority must lie in 0 \.\. 1. Got: 1\.5"):
        fixtures.change("ball", authority=1.5)
    with pytest.raises(ValueError, match="X_FG must be a pose"):
        fixtures.change("ball", X_W=np.zeros((4, 4)))
    assert given == []
    assert fixtures["ball"].section.authority == 1.0

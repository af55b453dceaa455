"""The judge `sign and direction` finds errors of a few times its tolerances: 0.1 % of a wrench, 0.2 um of a goal."""

import numpy as np
import pytest

from palpate_lab.verify.conformance import at_rest
from palpate_lab.verify.conformance.bench import Answer, Bench
from palpate_lab.verify.conformance.combinations import Combination

SOFT = Combination("forbid", "sphere", "spring", "soft")
HARD = Combination("forbid", "sphere", "spring", "hard")
TURNS = Combination("orient against the normal", "sphere", "spring", "soft")
RCM = Combination("rcm", "point", "spring", "hard")
CONFINED = Combination("keep-in", "box", "potential", "soft")


def altered(monkeypatch, change):
    """Replace every answer of the benches by `change(F, X)`, which returns a new F (n, 6) [N, N m] and X (n, 4, 4)."""
    run = Bench.run

    def changed(self, *given):
        out = run(self, *given)
        return Answer(*change(out.F, out.X), out.B)

    monkeypatch.setattr(Bench, "run", changed)


@pytest.mark.parametrize("error", [-0.003, 0.003])
@pytest.mark.parametrize("c", [SOFT, HARD, TURNS, RCM, CONFINED], ids=str)
def test_a_wrench_wrong_by_3_per_mille_is_found(monkeypatch, c, error):
    assert at_rest.sign_and_direction(c) == ""
    altered(monkeypatch, lambda F, X: ((1.0 + error) * F, X))
    assert "by finite differences" in at_rest.sign_and_direction(c)


@pytest.mark.parametrize("c", [SOFT, CONFINED, TURNS], ids=str)
def test_a_direction_wrong_by_3_mrad_is_found(monkeypatch, c):
    small = np.eye(3) + 3e-3 * np.array([[0.0, -1.0, 1.0], [1.0, 0.0, -1.0], [-1.0, 1.0, 0.0]])
    altered(monkeypatch, lambda F, X: (F @ np.kron(np.eye(2), small).T, X))
    assert "by finite differences" in at_rest.sign_and_direction(c)


def test_a_satisfied_fixture_that_pushes_with_a_tenth_of_a_millinewton_is_found(monkeypatch):
    altered(monkeypatch, lambda F, X: (F + [1e-4, 0.0, 0.0, 0.0, 0.0, 0.0] * ~F.any(axis=1, keepdims=True), X))
    assert "by finite differences [" in at_rest.sign_and_direction(SOFT)


@pytest.mark.parametrize(("shift", "words"), [(-1e-6, "promised"), (1e-5, "was needed")])
def test_a_goal_wrong_by_a_micrometre_is_found(monkeypatch, shift, words):
    """The sphere lies around the origin: `shift` moves the goal along the radius, inwards or too far outwards."""

    def moved(F, X):
        X = X.copy()
        X[:, :3, 3] *= 1.0 + shift / np.linalg.norm(X[:, :3, 3], axis=1, keepdims=True)
        return F, X

    altered(monkeypatch, moved)
    assert words in at_rest.sign_and_direction(HARD)

"""The figures of `palpate bench tissue`, short, and that each judge rejects tissue that is wrong."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import get_args

import numpy as np
import pytest

from palpate import Tissue
from palpate.scene.contact import render
from palpate_lab.commands.bench.tissue import Figure
from palpate_lab.verify.bench.tissue import (
    FIGURES,
    POISSON,
    YOUNG,
    Lab,
    finding,
    large_strain,
    lump,
    relaxing,
    run,
    table,
)
from palpate_lab.verify.tissue import reference_force


def made(**changes):
    """A lab whose bodies have changed values; a callable gets the right value."""

    def make(mesh, **values):
        changed = {key: change(values.get(key, ())) if callable(change) else change for key, change in changes.items()}
        return Tissue(mesh, **{**values, **changed})

    return Lab(make=make)


def felt(change):
    """A lab whose forces (n, 3) are changed."""

    def touch(*args, **how):
        out = render(*args, **how)
        return replace(out, force=change(out.force.copy()))

    return Lab(touch=touch)


def one_jump(force):
    force[len(force) // 3 :, 2] += 0.05
    return force


def jitter(force):
    force[:, 2] += 0.01 * (-1.0) ** np.arange(len(force))
    return force


def no_portable():
    """The portable kernel with a modulus .1 % too large."""
    return Lab(
        make=lambda mesh, portable=False, young=0.0, **values: Tissue(
            mesh, young=young * (1.001 if portable else 1.0), portable=portable, **values
        )
    )


def ideal(**case):
    """A lab that returns the forces of a reference, whatever the body is."""

    def touch(soft, tips, *, radius):
        depth = np.maximum(radius - tips[:, 2], 0.0)
        force = reference_force(radius, depth, YOUNG, POISSON, **case)
        return SimpleNamespace(force=force[:, None] * [0.0, 0.0, 1.0])

    return Lab(make=lambda *_, **__: None, touch=touch)


SHORT = ("large-strain", "stiffening", "viscosity", "smoothness", "energy", "kernels")


@pytest.mark.parametrize("name", SHORT)
def test_right_tissue_meets_its_limits(name):
    """Layers are in tests/tissue/test_soft_contact.py."""
    found = run([name], short=True)
    assert found["rows"]
    assert all(row["met"] for row in found["rows"]), found["rows"]
    assert table(found).row_count >= len(found["rows"])


@pytest.mark.parametrize(
    ("name", "lab", "words"),
    [
        ("layers", made(young=lambda E: 1.1 * E), "error"),
        ("large-strain", made(young=lambda E: 1.1 * E), "up to R/2"),
        ("large-strain", made(poisson=0.3), "up to R/2"),
        ("stiffening", ideal(h=large_strain.THICKNESS), "stiffening"),
        ("lump", ideal(lump=None, h=lump.THICKNESS), "lump"),
        ("viscosity", made(prony=()), "relaxation"),
        ("viscosity", made(prony=lambda terms: [(g, 2.0 * tau) for g, tau in terms]), "creep"),
        ("smoothness", felt(one_jump), "jump"),
        ("smoothness", felt(jitter), "noise"),
        ("energy", felt(np.negative), "energy"),
        ("kernels", no_portable(), "AVX2"),
    ],
)
def test_wrong_tissue_does_not(name, lab, words):
    rows = run([name], lab, short=True)["rows"]
    missed = [row["name"] for row in rows if not row["met"]]
    assert any(words in one for one in missed), rows


@pytest.mark.parametrize(
    ("name", "case"),
    [
        ("stiffening", {"h": large_strain.THICKNESS, "yeoh": 1.0}),
        ("lump", {"h": lump.THICKNESS, "lump": (lump.TOPS[0], lump.BALL, lump.RATIO)}),
    ],
)
def test_a_body_like_the_reference_meets_the_limits_of_stiffening_and_of_the_lump(name, case):
    assert all(row["met"] for row in run([name], ideal(**case), short=True)["rows"])


def test_theories_are_compared_with_the_reference():
    found = run(["theories"])
    by = {(row["theory"], row["poisson"], row["thickness_radii"]): row["error"] for row in found["theories"]}
    assert max(map(abs, by["Sneddon", 0.45, None])) < 0.01
    assert max(by["Hertz", 0.45, None]) > 0.05, "a paraboloid is wrong when deep"
    assert all(error < -0.02 for row in found["polynomial"] for error in row["error"]), "thin layers"
    assert table(found).row_count == len(found["theories"])


def test_the_command_offers_every_figure_and_json_always_has_its_keys():
    assert get_args(Figure) == tuple(FIGURES)
    found = run(["kernels"], short=True)
    assert found["tick_ms"] is None
    assert {"tick_ms", "control_ms", "layer_error", "ripple", "mujoco", "rows"} <= set(found)


@pytest.mark.parametrize("nu", [0.45, 0.4999])
def test_viscous_closed_form_has_its_limits(nu):
    """At once the shear modulus is that before relaxation, at last that at rest; creep is the inverse of relaxation."""
    prony, t = [(0.6, 0.1), (0.4, 1.0)], np.r_[0.0, np.geomspace(1e-3, 100.0, 4000)]
    force = relaxing.sphere_force(prony, nu, t, np.ones_like(t))
    bulk = 2.0 * (1.0 + nu) / (1.0 - 2.0 * nu)

    def plane(G):
        return 4.0 * G * (bulk + G) / (bulk + 4.0 * G)

    assert force[0] == pytest.approx(plane(2.0) / plane(1.0), rel=1e-9)
    assert force[-1] == pytest.approx(1.0, abs=1e-6)
    np.testing.assert_allclose(relaxing.sphere_creep(prony, nu, t, force), 1.0, atol=2e-3)


def test_an_operator_reports_a_lump_only_near_it():
    report = finding.Report(0.5, np.array([0.0, 0.0]))
    assert report.finds(np.array([0.004, 0.0]))
    assert not report.finds(np.array([0.02, 0.0]))
    assert not replace(report, contrast=0.1).finds(np.zeros(2)), "a difference that nobody notices"


def test_an_operator_compares_with_the_softer_places_and_not_with_a_wide_lump():
    places = np.stack([np.linspace(-0.018, 0.018, 10), np.zeros(10)], axis=1)
    wide = 60.0 * np.r_[np.ones(4), np.full(6, 1.4)]
    assert finding.judge(wide, places).contrast == pytest.approx(0.4)
    even = 60.0 * (1.0 + 0.08 * np.sin(np.arange(10)))
    assert finding.judge(even, places).contrast < finding.NOTICED, "control: errors of touch are no lump"

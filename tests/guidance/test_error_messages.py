"""Errors of invalid fixtures name key, value and remedy; units of ramps; keys that a role or law does not read."""

import numpy as np
import pytest

from palpate import _guidance
from palpate.base.errors import GuidanceError
from palpate.scene.guidance import Fixture, Sphere, from_yaml
from palpate.scene.guidance.geometry import as_guidance_error
from palpate.scene.guidance.sections import OF_LAW, OF_ROLE

BALL = "geometry: {sphere: {radius: 0.02}}"


@pytest.mark.parametrize(
    ("keys", "message", "mend"),
    [
        ("role: forbid, rise: 0", "rise must be at least 0.01. Got: 0", "at least"),
        ("role: forbid, fall: -1", "fall must be at least 0.01. Got: -1", "at least"),
        ("role: forbid, engage: 2 cm, release: 1 cm", "release 0.01 m is below engage 0.02 m", "release the larger"),
        (
            "role: forbid, law: {name: admittance, ratio: 0.001}",
            "law.ratio must be at least 0.01. Got: 0.001",
            "write a number at least 0.01",
        ),
        ("role: forbid, law: {name: spring, ratio: 0.5}", "spring does not read ratio", "it reads damping, stiffness"),
        ("role: {name: forbid, target: frame}", "forbid does not read target", "it reads margin: leave target out"),
        ("role: {name: orient, margin: 1 mm}", "orient does not read margin", "it reads angle_deg, axis, target"),
        (
            "role: {name: orient, target: frame, axis: [1, 0, 0]}",
            "orient does not read axis",
            "angle_deg, target: leave",
        ),
        ("role: orient, law: {stiffness: 800}", "role orient does not read law.stiffness", "law.turning_stiffness"),
        ("role: guide, law: {turning_damping: 0.1}", "guide does not read law.turning_damping", "it reads law.damping"),
        ("role: orient, law: {name: potential, force: 1}", "role orient does not read law.force", "law.moment"),
        ("role: guide, ramps: [{by: time, end: 3 mm}]", "end: '3 mm' of a ramp by time", "a plain number"),
        ("role: guide, ramps: [{by: distance, start: 3 mm, end: 0.003}]", "from 0.003 to 0.003", "must differ"),
        (
            "role: guide, ramps: [{by: distance, end: 3 ells}]",
            "end: '3 ells' of a ramp by distance",
            "a plain number [m], or one with its unit",
        ),
    ],
)
def test_mistake_is_reported_with_value_and_remedy(keys, message, mend):
    with pytest.raises(GuidanceError) as found:
        from_yaml(f"- {{{BALL}, {keys}}}")
    assert message in found.value.what
    assert mend in found.value.mend


def test_ramps_by_distance_take_lengths_with_units():
    one = Fixture(Sphere(radius=0.02), role="guide", ramps=[{"by": "distance", "start": "2 cm", "end": "0 mm"}])
    assert (one.ramps[0].start, one.ramps[0].end) == (0.02, 0.0)
    assert Fixture.from_yaml(one.to_yaml()) == one


def test_explicit_defaults_are_accepted():
    one = Fixture(Sphere(radius=0.02), role="forbid")
    assert Fixture.model_validate(one.model_dump(mode="json")) == one


def test_every_role_and_law_lists_its_keys():
    assert set(OF_ROLE) == set(_guidance.guidance_roles())
    assert set(OF_LAW) == set(_guidance.guidance_laws())


@pytest.mark.parametrize(
    ("make", "what", "mend"),
    [
        (lambda: _guidance.Fixtures([_fixture(rise=0.0)]), "rise = 0", "must be 0.01 s or more: no steps"),
        (lambda: _fixture(law_={"K": -1.0}), "law.stiffness = -1", "must be 0 N/m or more, and finite"),
        (lambda: _fixture(law_={"range_turn": 4.0}), "law.turning_range = 4", "must lie in 0..pi rad"),
        (
            lambda: _guidance.LineGeometry(np.zeros(3), np.zeros(3)),
            "a line needs two places that are finite and apart",
            "",
        ),
    ],
)
def test_error_messages_of_the_core_are_split_into_problem_and_remedy(make, what, mend):
    with pytest.raises(ValueError) as found:  # noqa: PT011 - checked below
        make()
    ours = as_guidance_error(found.value, "ball")
    assert (ours.what, ours.where, ours.mend) == (what, "ball", mend)


def _fixture(law_=None, **policy):
    from fixtures import fixture, plane

    return fixture(plane(), law_=law_, **policy)

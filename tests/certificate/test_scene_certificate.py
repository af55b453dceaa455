"""Certificates of scenes: agreement with the full simulation, the scene's hand, and unsupported laws."""

import warnings

import numpy as np
import pytest

import palpate
from palpate.certificate import certify_all
from palpate.certificate.scene import warn_outside
from palpate.certificate.touched import touched
from palpate.errors import PalpateError, PalpateWarning
from palpate.scene.rig import build
from palpate.studies.certificate import arms as certificate_arms
from palpate.viewer.staging import stable_below

SCENE = """
objects: [{name: table, plane: {size: 0.3}, stiffness: 800, damping: 1}]
operator: {path: [{t: 0, xyz: [0, 0, 0.02]}, {t: 1, xyz: [0, 0, -0.001]}]}
"""


def scene(text="", **update):
    return palpate.Scene.parse(SCENE + text).model_copy(update=update)


@pytest.fixture(scope="module")
def rig():
    return build(scene())


def test_full_simulation_oscillates_above_the_limit_and_settles_below(rig):
    """The simulation has seven joints, a hand, the follower's servo and a delay, and uses no code of the analysis."""
    n_W = np.array([0.6, 0.0, 0.8])
    delayed = build(scene(loop_delay=0.006))
    k, _ = certificate_arms.limit(delayed, n_W, 5.0)
    assert not certificate_arms.swings(delayed, n_W, 0.95 * k, 5.0)
    assert certificate_arms.swings(delayed, n_W, 1.05 * k, 5.0)


def test_advised_changes_raise_the_limit(rig):
    k = certify_all(rig.scene, rig=rig)[0].k_max
    assert palpate.certify(scene(loop_delay=0.01)).k_max < 0.7 * k
    assert palpate.certify(scene("arms: {follower: {bandwidth: 60}}")).k_max > 1.2 * k
    assert palpate.certify(scene("arms: {leader: {drive_lag: 0.004}}")).k_max < 0.95 * k
    assert palpate.certify(scene("stability: {low_pass: 10}")).k_max < 0.8 * k
    assert palpate.certify(scene(mapping=rig.scene.mapping.model_copy(update={"scale": 0.25}))).k_max == pytest.approx(
        2 * k, rel=0.05
    )


def test_the_scenes_own_hand_sets_the_limit(rig):
    hands = certify_all(rig.scene, rig=rig)[0].hands
    assert hands["normal"] == pytest.approx(certify_all(rig.scene, rig=rig)[0].k_max, rel=1e-6)
    assert list(np.argsort(list(hands.values()))) == list(range(5))
    light = SCENE.replace("operator: {", "operator: {hand: light, ")
    assert palpate.certify(palpate.Scene.parse(light)).k_max == pytest.approx(hands["light"], rel=0.02)


def test_each_region_has_a_certificate():
    nodule = palpate.Scene.load("scenes/nodule.yaml")
    assert [surface.name for surface in touched(build(nodule))] == ["liver", "liver, nodule"]


def test_unstable_object_warns_with_location_and_remedy():
    late = palpate.Scene.parse(SCENE + "loop_delay: 0.04\n", "late.yaml")
    with pytest.warns(PalpateWarning, match=r"late.yaml:2: table: unstable: 40 ms of delay .* would give"):
        warn_outside(build(late))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warn_outside(build(scene()))


def test_admittance_law_has_no_certificate():
    admittance = scene("torque: {law: admittance}")
    with pytest.raises(PalpateError, match=r"there is no certificate for torque\.law admittance"):
        palpate.certify(admittance)
    warn_outside(build(admittance))  # no warning without an analysis


def test_drive_based_force_source_has_no_certificate():
    bilateral = palpate.Scene.load("scenes/bilateral.yaml")
    with pytest.raises(PalpateError, match=r"there is no certificate for force\.source both"):
        palpate.certify(bilateral)


def test_the_most_damped_axis_is_also_checked():
    too_much = palpate.Scene.parse(SCENE.replace("damping: 1", "damping: [1, 1, 3000]"))
    assert palpate.certify(too_much).verdict == "unstable"
    assert (
        palpate.certify(palpate.DeviceModel(mass=0.3, damping=0.5, delay=0.005), K=0.0, B=1000.0).verdict == "unstable"
    )


def test_viewer_limit_is_that_of_the_stiffest_region_and_object():
    """The sliders scale all stiffnesses, so the limit shown for the first object must hold for every object."""
    one = "{name: table, plane: {size: 0.3}, stiffness: 800, damping: 1}"
    stiff = one.replace("table, ", "ceiling, pose: {xyz: [0, 0, 0.2], rpy_deg: [180, 0, 0]}, ").replace("800", "2400")
    alone, both = (build(palpate.Scene.parse(SCENE.replace(one, text))) for text in (one, f"{one}, {stiff}"))
    limits = [stable_below(rig) for rig in (alone, both)]
    assert limits[0] is not None
    assert limits[1] is not None
    assert limits[1](2.0) == pytest.approx(limits[0](2.0) / 3.0, rel=1e-6)

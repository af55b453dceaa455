"""The certificate of a scene that is felt across a network."""

import warnings
from dataclasses import replace

import pytest

from palpate.devices.certificate.remote import remote_limits
from palpate.devices.certificate.scene import certificates
from palpate.scene import Scene
from palpate.scene.rig import build


@pytest.fixture(scope="module")
def rig():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return build(Scene.load("remote"))


def test_direct_is_stable_to_the_delay_at_which_the_certificate_of_the_delayed_loop_ends(rig):
    found = remote_limits(rig)
    assert found.mode == "model"
    assert found.model_stable_to_ms is None
    assert found.stiffness_N_per_m == 450.0
    assert 5.0 < found.direct_stable_to_ms < 500.0

    def limit(delay):
        scene = rig.scene.model_copy(update={"loop_delay": delay})
        return min(one.k_max for one in certificates(scene, 450.0, None, replace(rig, scene=scene)))

    assert limit(1e-3 * found.direct_stable_to_ms) > 450.0
    assert limit(1.1e-3 * found.direct_stable_to_ms) <= 450.0
    assert "direct to a round trip of" in found.words()


def test_a_scene_without_a_remote_site_has_no_such_limits(rig):
    assert remote_limits(replace(rig, scene=rig.scene.model_copy(update={"remote": None}))) is None

"""A contact method that cannot render an object is rejected at set-up, and when a scene is replaced."""

import numpy as np
import pytest

from palpate import _core
from palpate.base.errors import SceneError
from palpate.scene import Scene, rig

BALL = _core.Snapshot([_core.Object("ball", _core.Sphere(0.03), np.eye(4), _core.Material())])


def test_method_of_triangles_rejects_a_primitive():
    organ = {"objects": [{"shape": "organ"}], "contact": {"method": "paper-plane"}}
    with pytest.raises(SceneError, match=r"object 'ball' has no triangles") as raised:
        rig.check_method(Scene.model_validate(organ), BALL)
    assert "contact" in str(raised.value).splitlines()[0]
    assert raised.value.mend == "change contact.method"


def test_replacing_scene_is_checked_for_the_method():
    organ = {"objects": [{"shape": "organ", "triangles": 2000}], "contact": {"method": "paper-alg1"}}
    simulation = rig.build(Scene.model_validate(organ)).simulation()
    with pytest.raises(ValueError, match=r"object 'ball' has no triangles"):
        simulation.set_snapshot(BALL)


def test_release_depth_is_that_of_the_scene_and_must_be_positive():
    box = "objects: [{box: {size: [0.1, 0.1, 0.02]}}]\ncontact: {release: 0.03}\n"
    assert rig.build(Scene.parse(box, "s.yaml")).options().contact.release == 0.03
    with pytest.raises(SceneError, match=r"contact\.release"):
        Scene.parse(box.replace("0.03", "0"), "s.yaml")

"""A contact method that cannot feel an object is refused when the scene is set up, and when a scene is swapped in."""

import numpy as np
import pytest

from palpate import _core
from palpate.errors import SceneError
from palpate.scene import Scene, rig

BALL = _core.Snapshot([_core.Object("ball", _core.Sphere(0.03), np.eye(4), _core.Material())])


def test_a_primitive_and_a_method_of_triangles():
    organ = {"objects": [{"shape": "organ"}], "contact": {"method": "paper-plane"}}
    with pytest.raises(SceneError, match=r"object 'ball' has no triangles") as told:
        rig.check_method(Scene.model_validate(organ), BALL)
    assert "contact" in str(told.value).splitlines()[0]
    assert told.value.mend == "change contact.method"


def test_a_scene_swapped_in_while_it_runs():
    organ = {"objects": [{"shape": "organ", "triangles": 2000}], "contact": {"method": "paper-alg1"}}
    simulation = rig.build(Scene.model_validate(organ)).simulation()
    with pytest.raises(ValueError, match=r"object 'ball' has no triangles"):
        simulation.set_snapshot(BALL)


def test_where_a_tool_that_went_through_is_let_go():
    box = "objects: [{box: {size: [0.1, 0.1, 0.02]}}]\ncontact: {release: 0.03}\n"
    assert rig.build(Scene.parse(box, "s.yaml")).options().contact.release == 0.03
    with pytest.raises(SceneError, match=r"contact\.release"):
        Scene.parse(box.replace("0.03", "0"), "s.yaml")

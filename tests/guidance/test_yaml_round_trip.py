"""Every geometry and key survives a YAML round trip, reaches the core, and can be drawn."""

import matplotlib as mpl
import numpy as np
import pytest
from fixtures import pose
from scipy.spatial.transform import Rotation

from palpate import _core, _guidance
from palpate.base.errors import GuidanceError
from palpate.scene import guidance
from palpate.scene.guidance import Fixture, FixtureContext, Geometry, Mesh, OfObject, Role, Sphere, from_yaml, to_yaml
from palpate.scene.guidance.plot import query
from palpate.scene.guidance.sections import Frame, LawName, RoleName

mpl.use("Agg")

SHAPES = {
    "point": {"at": [0.01, 0, 0]},
    "line": {"start": [0, 0, 0], "end": ["5 mm", 0, 0]},
    "plane": {"at": [0, 0, 0.01], "normal": [0, 1, 1]},
    "path": {"waypoints": [[0, 0, 0], [0.01, 0.01, 0], [0.02, 0, 0]]},
    "tube": {"waypoints": [[0, 0, 0], [0.01, 0.01, 0], [0.02, 0, 0]], "radius": "3 mm"},
    "cone": {"entry": [0, 0, 0.1], "target": [0, 0, 0]},
    "sphere": {"radius": 0.02, "at": [0, 0, 0.01]},
    "box": {"size": [0.02, 0.03, 0.04]},
    "cylinder": {"radius": 0.01, "length": 0.05},
    "mesh": {"file": "ball.stl"},
    "cloud": {"file": "cloud.csv", "radius": "2 mm"},
    "grid": {"file": "ball.stl", "spacing": "2 mm"},
    "object": {"name": "liver"},
    "offset": {"of": {"sphere": {"radius": 0.02}}, "margin": "-2 mm"},
    "union": {"of": [{"sphere": {"radius": 0.02}}, {"box": {"size": [0.05, 0.01, 0.01]}}], "blend": "1 mm"},
    "intersection": {"of": [{"sphere": {"radius": 0.02}}, {"plane": {}}]},
    "difference": {"of": [{"sphere": {"radius": 0.02}}, {"plane": {}}]},
}


def query_at(fixture, points, here, t=0.0):
    return query(fixture.make_geometry(here), points, t)


def test_every_geometry_has_an_example_and_every_name_is_that_of_the_core():
    assert set(SHAPES) == set(Geometry.model_fields)
    assert set(RoleName.__args__) == set(_guidance.guidance_roles())
    assert set(LawName.__args__) == set(_guidance.guidance_laws())


@pytest.mark.parametrize("key", SHAPES)
def test_every_geometry_survives_a_round_trip(key, here):
    fixture = Fixture(geometry={key: SHAPES[key]}, role="guide", name="it")
    again = Fixture.from_yaml(fixture.to_yaml())
    assert again == fixture
    assert Fixture.model_validate(fixture.model_dump(mode="json")) == fixture
    where = np.random.default_rng(1).uniform(-0.05, 0.05, (100, 3))
    np.testing.assert_array_equal(query_at(again, where, here)["distance"], query_at(fixture, where, here)["distance"])
    assert fixture.make(here).role == "guide"


def test_every_other_key_survives_a_round_trip_and_reaches_the_core(here):
    fixture = Fixture(
        Sphere(radius=0.02),
        name="ball",
        role={"name": "keep-in", "margin": "1 mm"},
        law={"name": "potential", "stiffness": 700.0, "range": "4 mm", "force": 2.0},
        frame={"of": "liver", "pose": {"xyz": [0, 0, 0.1]}},
        hard=True,
        authority=0.5,
        priority=3,
        engage=0.05,
        release=0.06,
        rise=0.3,
        ramps=[{"by": "distance", "start": 0.02, "end": 0.0}],
        enabled=False,
    )
    assert Fixture.from_yaml(fixture.to_yaml()) == fixture
    assert "damping" not in fixture.to_yaml(), "defaults are not written"
    core = fixture.make(here)
    policy = (core.policy.hard, core.policy.authority, core.policy.priority, core.policy.engage, core.policy.release)
    assert policy == (True, 0.5, 3, 0.05, 0.06)
    assert (core.policy.rise, core.stiffness, core.on, core.law) == (0.3, 700.0, False, "potential")
    assert [(r.by, r.start, r.end) for r in core.policy.ramps] == [("distance", 0.02, 0.0)]
    gap = core.evaluate(pose((0, 0, 0.1)))["gap"]
    assert gap == pytest.approx(0.02 - 0.001)


WITHOUT_AXIS = {"point", "sphere", "cloud", "object", "offset", "union", "intersection", "difference"}


@pytest.mark.parametrize("key", SHAPES)
def test_orient_needs_a_geometry_with_an_axis(key, here):
    """Points, balls, clouds and their combinations have no axis; planes, lines, meshes and rotated geometries do."""
    fixture = Fixture(geometry={key: SHAPES[key]}, role="orient", name="it")
    assert fixture.make_geometry(here).has_axis == (key not in WITHOUT_AXIS)
    if key in WITHOUT_AXIS:
        with pytest.raises(GuidanceError, match="role orient with target axis needs a geometry that has one") as found:
            fixture.make(here)
        assert found.value.mend.startswith("turn it (rpy_deg), give a line through the place")
    turned = fixture.model_copy(update={"frame": Frame(pose={"rpy_deg": [0, 20, 0]})})
    assert turned.make(here).role == "orient"
    for target in ("normal", "frame"):
        other = fixture.model_copy(update={"role": Role(name="orient", target=target)})
        assert other.make(here).role == "orient"


def test_rotated_point_or_point_on_a_live_frame_has_the_axis_of_its_frame(here):
    common = {"name": "it", "role": "orient"}
    turned = Fixture(geometry={"point": {"at": [0, 0, 0], "rpy_deg": [90, 0, 0]}}, **common).make(here)
    tool = Rotation.from_euler("x", 90, degrees=True).as_matrix()
    assert turned.evaluate(pose((0.01, 0, 0), tool))["gap"] == pytest.approx(0.0, abs=1e-9)
    live = FixtureContext(here.file, {**here.frames, "camera": _core.LiveFrame()}, {}, {})
    assert Fixture(geometry={"point": {"at": [0, 0, 0]}}, frame="camera", **common).make(live).role == "orient"


def test_only_orient_engages_and_fades_by_angles():
    by_angle = {"engage_deg": 10, "release_deg": 20, "ramps": [{"by": "angle", "start": 5, "end": 15}]}
    f = Fixture(guidance.Line(start=(0, 0, 0), end=(0, 0, 1)), role="orient", **by_angle)
    assert list(from_yaml(f.to_yaml())) == [f]
    policy = f.make().policy
    assert (policy.engage, policy.release) == pytest.approx((np.radians(10), np.radians(20)))
    assert (policy.ramps[0].start, policy.ramps[0].end) == pytest.approx((np.radians(5), np.radians(15)))
    by_place = {"engage": "2 mm", "release": "3 mm", "ramps": [{"by": "distance", "end": "1 cm"}]}
    for role, keys, read in (("orient", by_place, "angle|_deg"), ("guide", by_angle, "distance|engage|release")):
        for key, value in keys.items():
            with pytest.raises(ValueError, match=rf"role {role} does not read .*\n  mend: it reads .*({read})"):
                Fixture(guidance.Line(start=(0, 0, 0), end=(0, 0, 1)), role=role, **{key: value})


def test_several_fixtures_survive_a_round_trip():
    fixtures = [Fixture("margin: 3 mm around: ball.stl"), Fixture(Mesh(file="ball.stl"), role="guide", name="b")]
    assert list(from_yaml(to_yaml(fixtures))) == fixtures


def test_fixture_moves_with_its_object(here):
    fixture = Fixture(OfObject(name="liver"), role="forbid", frame="liver")
    q = query_at(fixture, [[1, 1, 1.1]], here, t=1.0)
    np.testing.assert_allclose(q["distance"], 0.07)
    np.testing.assert_allclose(q["velocity"], [[1, 1, 1]])


def test_defaults_are_those_of_the_core():
    fixture = Fixture(Sphere(radius=0.02), role="guide")
    o, r, p = _core.GuidanceLawOptions(), _core.GuidanceRoleOptions(), _core.Policy()
    assert (fixture.law.stiffness, fixture.law.damping, fixture.law.range) == (o.K, o.B, o.range)
    assert (fixture.role.margin, fixture.authority, fixture.hard) == (r.margin, p.authority, p.hard)
    cone = guidance.Cone(entry=(0, 0, 1), target=(0, 0, 0))
    assert np.radians(cone.half_angle_deg) == pytest.approx(_core.CONE_HALF_ANGLE)


@pytest.mark.parametrize("key", SHAPES)
def test_every_geometry_can_be_drawn(key, here):
    role = {"name": "forbid" if key not in ("point", "line", "path") else "guide", "margin": 0.002}
    axes = Fixture(geometry={key: SHAPES[key]}, role=role).plot(context=here)
    assert axes.collections or axes.lines
    mpl.pyplot.close("all")

"""Regions, motion and tool geometry, from the scene file to the core and to the drawing."""

import numpy as np
import pytest

from palpate import Arm, Scene, Session
from palpate.base.errors import PalpateWarning, SceneError
from palpate.record.ticks import SIGNALS, as_ticks
from palpate.scene.rig import build
from palpate.viewer.staging import stage_of

BASE = "objects:\n  - shape: organ\n    triangles: 4000\n    stiffness: 300\n    friction: 0.1\n"


def rig(text):
    return build(Scene.parse(BASE + text, "s.yaml"))


def test_region_inherits_missing_values_from_its_object():
    obj = rig("    regions: [{at: [0, 0, 0.02], radius: 0.005, stiffness: 900}]\n").snapshot.objects[0]
    inside, outside = obj.feel(np.array([0, 0, 0.021]))[0], obj.feel(np.zeros(3))[0]
    assert (inside.K[0], inside.mu, outside.K[0]) == (900, 0.1, 300)


def test_box_region_keeps_its_lengths_with_round_edges():
    box = "{at: [0, 0, 0], box: [0.02, 0.02, 0.02], radius: 0.004, blend: 0.001, stiffness: 900}"
    obj = rig(f"    regions: [{box}]\n").snapshot.objects[0]
    for p, K in (([0.0099, 0, 0], 900), ([0, 0.0111, 0], 300), ([0.0082, 0.0082, 0.0082], 900), ([0.01] * 3, 300)):
        assert obj.feel(np.array(p))[0].K[0] == K, p


def test_motions_add_up_about_the_centre_of_the_object():
    one = rig("    motion: {amplitude: [0, 0, 0.004], period: 4}\n").snapshot.objects[0]
    np.testing.assert_allclose(one.pose(1.0)[:3, 3], [0, 0, 0.004], atol=1e-15)
    made = rig(
        "    motion:\n      - {amplitude: [0, 0, 0.004]}\n      - {velocity: [0.01, 0, 0], spin_deg: [0, 0, 90]}\n"
    )
    two, middle = made.snapshot.objects[0], np.append(made.surfaces[0].bounds.mean(axis=0), 1.0)
    np.testing.assert_allclose((two.pose(1.0) @ middle)[:3], middle[:3] + np.array([0.01, 0, 0.004]), atol=1e-12)
    np.testing.assert_allclose(two.pose(1.0)[:3, 0], [0, 1, 0], atol=1e-12)


def test_tool_spheres_follow_the_links_of_the_follower():
    """Spheres of jaws and wrist are at their links, those of the shaft on the line through the remote centre."""
    made = rig("contact: {whole_tool: true}\n")
    assert [s.name for s in made.spheres[:4]] == ["jaw_1", "jaw_2", "wrist", "shaft 1"]
    assert len(made.spheres) == 15
    arm, q, jaw = Arm.psm("lnd"), np.array([0.2, -0.3, 0.15, 0.4, 0.3, -0.5]), 0.6
    links = arm.link_poses(q, jaw)
    for sphere in made.spheres:
        on = sphere.name.split()[0]
        p_link = next(s["at"] for s in arm.spheres if s["link"] == on)
        if on.startswith("jaw") or sphere.name.endswith(" 1") or on == "wrist":
            p = sphere.centre(arm.fk(q), np.eye(4), links, jaw)
            np.testing.assert_allclose(p, (links[on] @ [*p_link, 1.0])[:3], atol=1e-15)
    shaft = [s.centre(arm.fk(q), np.eye(4), links, jaw) for s in made.spheres if s.name.startswith("shaft")]
    away = np.cross(shaft, shaft[0] / np.linalg.norm(shaft[0]))
    np.testing.assert_allclose(away, 0, atol=1e-12)  # on the line through the remote centre, the origin of B


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("contact: {spheres: [{link: elbow, radius: 0.01}]}\n", "there is no link 'elbow'"),
        ("contact: {whole_tool: true, spheres: [{radius: 0.01}]}\n", "16 spheres in addition to the one on the tip"),
        ("    regions: [{at: [0, 0, 0]}]\n", "has no size"),
        ("    regions: [{at: [0, 0, 0], radius: 0.01, stiffness: 9000}]\n", "region 'region': stiffness 9000 N/m"),
        ("    motion: {amplitude: [0, 0, 0.004], period: 0}\n", "motion"),
        ("    regions: [{at: [0, 0, 0], box: [0.1, 0.01, 0.1], radius: 0.006}]\n", "do not fit into a box 0.01 m wide"),
        ("    static_friction: 0.05\n", "0.05 is less than friction 0.1"),
        ("    regions: [{at: [0, 0, 0], radius: 0.01, friction: 1, static_friction: 0}]\n", "less than friction 1"),
    ],
)  # fmt: skip
def test_invalid_tissue_is_reported(text, message):
    with pytest.raises(SceneError, match=message):
        rig(text)


def test_region_outside_its_object_gives_a_warning():
    with pytest.warns(PalpateWarning, match=r"region 'region' lies .* mm outside of .*: never felt"):
        rig("    regions: [{at: [0, 0, 37.5], radius: 0.006}]\n")


def test_run_reports_each_contact():
    """All spheres on a breathing organ: sphere, object, force and position on the moved surface of each contact."""
    session = Session(Scene.load("scenes/breathing.yaml"))
    ticks, again = (as_ticks(session.rig.simulation(0).run(3000)) for _ in range(2))
    for signal in SIGNALS.values():
        if signal.deterministic:
            np.testing.assert_array_equal(ticks[signal.name], again[signal.name])
    touching = ticks[ticks["contacts"] > 0]
    assert len(touching) > 500
    assert set(np.unique(touching["touch_sphere"][:, 0])) <= set(range(16))
    assert (np.diff(touching["touch_force"], axis=1) <= 0).all()  # sorted by force, zero after the last
    row = touching[-1]
    n = int(row["contacts"])
    X = session.rig.snapshot.objects[0].pose(float(row["t"]))
    points = (row["p_WC"].reshape(-1, 3)[:n] - X[:3, 3]) @ X[:3, :3]
    distance = session.rig.surfaces[0].body.core.nearest(np.ascontiguousarray(points))[0]
    assert np.abs(distance).max() < 5e-4  # the rendered surface is smooth, the reference has facets; friction lags
    stage = stage_of(session.rig)
    assert len(stage.touches(row)) == n
    assert "liver" in stage.touches(row)[0]


def test_viewer_gets_moving_and_coloured_parts():
    stage = stage_of(rig("    regions: [{name: lump, at: [-0.035, -0.01, 0.04], radius: 0.012, stiffness: 900}]\n"))
    (mark,) = stage.objects[0].regions
    assert mark.name == "lump"
    assert 0 < mark.triangles.sum() < 0.2 * len(mark.triangles)
    assert stage.objects[0].moving is None
    moving = stage_of(rig("    motion: {amplitude: [0, 0, 0.004]}\n")).objects[0].moving
    np.testing.assert_allclose(moving(1.0)[:3, 3], [0, 0, 0.004], atol=1e-15)

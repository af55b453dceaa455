"""Several spheres of the tool on one surface: which ones touch, the coupled loop, and the full simulation."""

import itertools

import numpy as np
import pytest

import palpate
from palpate.devices.certificate import certify_all
from palpate.devices.certificate.arms import HeldLeader
from palpate.devices.certificate.coupled import CoupledLoop
from palpate.devices.certificate.loop import SampledLoop, modes
from palpate.devices.certificate.scene import _Arms
from palpate.devices.certificate.spheres import Spheres, longest, plane_contacts, postures
from palpate.devices.certificate.touched import touched
from palpate.scene.rig import build
from palpate_lab.studies.certificate import arms as certificate_arms

SCENE = """
objects: [{{name: table, plane: {{size: 0.3}}, stiffness: {K}, damping: {B}}}]
contact: {{radius: 0.002, spheres: [{spheres}]}}
operator: {{path: [{{t: 0, xyz: [0, 0, 0.02]}}, {{t: 1, xyz: [0, 0, -0.001]}}]}}
stability: {{passivity: off}}
"""
Z = np.array([0.0, 0.0, 1.0])


def in_the_plane_of_the_tip(K=1400, B=0, away=0.004):
    """A scene with a second sphere beside the tip, at the same height above the table."""
    rig = build(palpate.Scene.parse(SCENE.format(K=K, B=B, spheres="")))
    R_WT = (rig.arms.X_WB @ rig.arms.follower.fk(rig.arms.q_follower0))[:3, :3]
    at = (R_WT.T @ [away, 0.0, 0.0]).tolist()
    return build(palpate.Scene.parse(SCENE.format(K=K, B=B, spheres=f"{{at: {at}, radius: 0.002}}")))


@pytest.fixture(scope="module")
def two():
    return in_the_plane_of_the_tip()


def balls(*centres, radius=0.002):
    motion = np.broadcast_to(np.hstack([np.eye(3), np.zeros((3, 3))]), (len(centres), 3, 6))
    return Spheres(np.array(centres, dtype=float), np.full(len(centres), radius), motion)


@pytest.mark.parametrize(("depth", "count"), [(0.5e-3, 1), (1.1e-3, 2), (2.9e-3, 2), (3.1e-3, 3), (0.1, 4)])
def test_a_sphere_touches_where_the_force_of_the_others_is_below_the_cap(depth, count):
    """Heights 0, 1, 2 and 20 mm. The second touches at 1 mm of K; the third when 2 mm + 1 mm press."""
    tool = balls((0, 0, 0), (0.01, 0, 0.001), (0.02, 0, 0.002), (0.03, 0, 0.02))
    assert tool.at_once(Z[None], depth)[0].sum() == count


def test_planes_on_two_spheres_touch_both_and_cut_none_of_the_two():
    tool = Spheres(np.array([[0, 0, 0], [0.01, 0.002, -0.001]]), np.array([0.002, 0.004]), np.zeros((2, 3, 6)))
    heights = tool.centres @ tool.tangent_normals().T - tool.radii[:, None]
    np.testing.assert_allclose(heights[0], heights[1], atol=1e-12)
    assert tool.length == pytest.approx(0.006 + np.linalg.norm(tool.centres[1]))
    axis = tool.centres[1] / np.linalg.norm(tool.centres[1])
    across = tool.tangent_normals() - (tool.tangent_normals() @ axis)[:, None] * axis
    np.testing.assert_allclose(across.mean(axis=0), 0.0, atol=1e-12, err_msg="from all sides")
    assert len(np.unique(across.round(9), axis=0)) == 72
    np.testing.assert_allclose(np.linalg.norm(tool.tangent_normals(), axis=1), 1.0)
    within = Spheres(np.array([[0, 0, 0], [0.001, 0, 0]]), np.array([0.004, 0.002]), np.zeros((2, 3, 6)))
    assert len(within.tangent_normals()) == 0, "one within the other"


def test_springs_are_the_derivative_of_forces_and_moments():
    """Reference: forces of two springs on a rigid tool that is moved and turned by little."""
    rng = np.random.default_rng(3)
    tool = Spheres(rng.normal(size=(2, 3)), np.ones(2), rng.normal(size=(2, 3, 6)))
    n = np.array([0.6, 0.0, 0.8])
    spring, damper = tool.springs(n, np.array([True, True]))
    for x in np.eye(6):
        for J, found in ((tool.motion, spring), (rigid(tool), damper)):
            forces = [(n @ J[i] @ x) * n for i in range(2)]
            moment = sum(np.cross(tool.centres[i] - tool.centres[0], forces[i]) for i in range(2))
            np.testing.assert_allclose(found @ x, [*sum(forces), *moment], atol=1e-12)


def rigid(tool):
    return [np.hstack([np.eye(3), -np.cross(np.eye(3), c - tool.centres[0])]) for c in tool.centres]


def test_motion_of_the_spheres_is_that_of_the_instrument():
    """Jaws move with the tip; the shaft swings about the remote centre, by less the nearer it is."""
    rig = build(palpate.Scene.parse(SCENE.format(K=400, B=0, spheres="").replace("spheres: []", "whole_tool: true")))
    tool = postures(rig, ())[0][0]
    np.testing.assert_allclose(tool.motion[:3, :, :3], np.broadcast_to(np.eye(3), (3, 3, 3)), atol=1e-3)
    shaft = np.flatnonzero(tool.radii == 0.0042)
    remote = rig.arms.X_WB[:3, 3]
    along = tool.centres[shaft] - remote
    across = np.cross(along[0], Z) / np.linalg.norm(np.cross(along[0], Z))
    swing = np.einsum("j,ijk,k->i", across, tool.motion[shaft, :, :3], across)
    ratio = np.linalg.norm(along, axis=1) / np.linalg.norm(along[0])
    np.testing.assert_allclose(swing / swing[0], ratio, rtol=0.02)


def test_one_sphere_on_the_tip_has_the_limit_of_the_single_loop(two):
    """The winding number of the coupled loop against the crossings of the single one."""
    o = two.options()
    held, n = HeldLeader(two.arms.leader, two.arms.q_leader0, o, o.hand), np.array([0.6, 0.0, 0.8])
    push = np.zeros((6, 6))
    push[:3, :3] = np.outer(n, n)
    single, coupled = held.loop(n), held.coupled(push, push)
    assert coupled.B_max == pytest.approx(single.B_max, rel=1e-3)
    for B in (0.0, 5.0):
        K, w = coupled.K_max(B)
        assert (K, w) == pytest.approx(single.K_max(B), rel=0.02)
        assert pytest.approx(single.K_max(B)[0], rel=1e-3) == K
    assert coupled.K_max(1.01 * single.B_max) == single.K_max(1.01 * single.B_max) == (0.0, 0.0)
    assert coupled.delayed(0.01).K_max(0.0)[0] == pytest.approx(single.delayed(0.01).K_max(0.0)[0], rel=1e-3)


def test_two_spheres_oscillate_where_one_is_certified(two):
    """In the full simulation, with 1400 N/m: one sphere comes to rest, two oscillate, and at 95 % of the limit rest."""
    alone, both = certify_all(two.scene, rig=two)
    assert (alone.verdict, both.verdict) == ("stable", "unstable")
    assert both.k_max == pytest.approx(0.5 * alone.k_max, rel=0.05)
    passive = [one.bounds["colgate_brown_with_hand"] for one in (alone, both)]
    assert passive[1] == pytest.approx(0.5 * passive[0]), "two springs, without damping"
    assert both.k_max == pytest.approx(1150.0, rel=0.01), "docs/certificate.md"
    assert "2 of its spheres" in both.worst
    one = build(palpate.Scene.parse(SCENE.format(K=1400, B=0, spheres="")))
    assert not certificate_arms.swings(one, Z, 1400.0, 0.0)
    assert certificate_arms.swings(two, Z, 1400.0, 0.0)
    assert not certificate_arms.swings(two, Z, 0.95 * both.k_max, 0.0)


def test_a_sphere_1_mm_above_touches_surfaces_that_reach_the_force_cap_deeper():
    """The cap of 3 N is reached at 1 mm of 3000 N/m."""
    flat = build(palpate.Scene.parse(SCENE.format(K=1400, B=0, spheres="")))
    R_WT = (flat.arms.X_WB @ flat.arms.follower.fk(flat.arms.q_follower0))[:3, :3]
    at = (R_WT.T @ [0.004, 0.0, 0.001]).tolist()
    arms = _Arms(build(palpate.Scene.parse(SCENE.format(K=1400, B=0, spheres=f"{{at: {at}, radius: 0.002}}"))))
    row = touched(arms.rig)[1]
    scale = arms.o.mapping.force_scale
    assert {one.count for one in arms._contacts(row, 2950.0 / scale) if one.posture == 0} == {2}
    assert {one.count for one in arms._contacts(row, 3050.0 / scale) if one.posture == 0} == {1}


def test_rows_of_a_tool_of_several_spheres(two):
    assert [one.name for one in touched(two)] == ["table", "table, whole tool"]
    assert [one.several for one in touched(two)] == [False, True]


@pytest.mark.parametrize(("depth", "count"), [(5.9e-3, 6), (6.1e-3, 12)])
def test_more_spheres_touch_a_softer_surface(depth, count):
    """Six spheres at 0 and six at 1 mm: these touch when the first six press by 6 mm in all."""
    tool = (balls(*itertools.product((0, 0.004, 0.008), (0, 0.005), (0, 0.001))),)
    assert [one.count for one in plane_contacts([tool], depth, Z)] == [count]
    assert max(one.count for one in plane_contacts([tool], depth, None)) >= count


def test_length_of_the_tool_is_the_largest_of_its_postures(two):
    """The postures have the motion of the spheres too, which the length does not need."""
    expected = max(tool.length for jaws in postures(two, (0.3, 0.6)) for tool in jaws)
    assert longest(two, (0.3, 0.6)) == expected == pytest.approx(0.008, abs=1e-9)
    alone = build(palpate.Scene.parse(SCENE.format(K=1400, B=0, spheres="")))
    assert longest(alone, ()) == pytest.approx(0.004)
    assert postures(alone, ())[0][0].length == pytest.approx(0.004)


def masses(m, b, k):
    """Independent masses (6,) with dampers and springs, as a plant of six axes, and each axis alone."""
    zero, one = np.zeros((6, 6)), np.eye(6)
    A = np.block([[zero, one], [-np.diag(k / m), -np.diag(b / m)]])
    inputs, c, d = np.vstack([zero, np.diag(1.0 / m)]), np.hstack([one, zero]), np.hstack([zero, one])
    return A, inputs, c, d


def test_independent_axes_have_the_least_limit_of_all_and_springs_in_parallel_reduce_it():
    """Reference: the loops of the single axes, within the spacing of the coupled loop's frequencies."""
    rng = np.random.default_rng(4)
    m, b, k = 10.0 ** rng.uniform(-1.0, 0.0, 6), rng.uniform(8.0, 25.0, 6), rng.uniform(0.0, 300.0, 6)
    A, inputs, c, d = masses(m, b, k)
    T, delay, parallel = 1e-3, 2.3e-3, 60.0
    gains = np.array([1.0, 0.5, 2.0, 1.0, 0.3, 0.7])

    def coupled(fixtures):
        G, one = np.diag(gains), np.ones_like
        return CoupledLoop(A, inputs, c, d, T, delay, G, G, fixtures * np.eye(6), one, one, one, modes(A))

    def alone(i, fixtures):
        loop = SampledLoop(A, inputs[:, i], c[i], T, delay, d=d[i], parallel_stiffness=fixtures)
        return loop, [x / gains[i] for x in (loop.B_max, loop.K_max(0.0)[0], loop.K_max(gains[i] * 3.0)[0])]

    for fixtures in (0.0, parallel):
        B_max, K_0, K_3 = np.min([alone(i, fixtures)[1] for i in range(6)], axis=0)
        loop = coupled(fixtures)
        assert loop.B_max == pytest.approx(B_max, rel=0.01)
        assert loop.K_max(0.0)[0] == pytest.approx(K_0, rel=0.01)
        assert loop.K_max(3.0)[0] == pytest.approx(K_3, rel=0.01)
    assert coupled(1e5).K_max(0.0) == (0.0, 0.0), "the parallel springs alone are too stiff"


@pytest.mark.parametrize("seed", [3, 6, 9])
def test_limits_of_lightly_damped_axes_are_those_of_each_axis_alone(seed):
    """Damping ratios below 5 %, where the phase turns fast, and springs so soft that a pole lies below the grid."""
    rng = np.random.default_rng(seed)
    m, b, k = 10.0 ** rng.uniform(-1.0, 0.0, 6), rng.uniform(0.05, 0.2, 6), rng.uniform(0.0, 300.0, 6)
    A, inputs, c, d = masses(m, b, k)
    gains, one = np.array([1.0, 0.5, 2.0, 1.0, 0.3, 0.7]), np.ones_like
    G = np.diag(gains)
    coupled = CoupledLoop(A, inputs, c, d, 1e-3, 2.3e-3, G, G, np.zeros((6, 6)), one, one, one, modes(A))
    alone = [SampledLoop(A, inputs[:, i], c[i], 1e-3, 2.3e-3, d=d[i]) for i in range(6)]
    assert coupled.B_max == pytest.approx(min(x.B_max / g for x, g in zip(alone, gains, strict=True)), rel=5e-4)
    for B in (0.0, 3.0):
        limits = [(x.K_max(g * B)[0] / g, x.K_max(g * B)[1]) for x, g in zip(alone, gains, strict=True)]
        K, w = min(limits)
        assert coupled.K_max(B)[0] == pytest.approx(K, rel=5e-4)
        assert coupled.K_max(B)[1] == pytest.approx(w, rel=5e-3)


def test_all_spheres_touch_a_surface_without_stiffness(two):
    far = build(palpate.Scene.parse(SCENE.format(K=1400, B=0, spheres="{at: [0, 0, -0.03], radius: 0.002}")))
    arms = _Arms(far)
    assert {one.count for one in arms._contacts(touched(far)[1], 0.0)} == {2}
    assert [one.verdict for one in certify_all(two.scene, K=0.0, rig=two)] == ["stable", "stable"]


def test_the_spheres_of_a_too_stiff_surface_are_those_that_touch_at_its_limit():
    """Only one touches a very stiff surface before the force cap, two the one at the limit, and three a soft one."""
    flat = build(palpate.Scene.parse(SCENE.format(K=1400, B=0, spheres="")))
    R_WT = (flat.arms.X_WB @ flat.arms.follower.fk(flat.arms.q_follower0))[:3, :3]
    places = ((R_WT.T @ [0.004, 0.0, height]).tolist() for height in (0.0005, 0.01))
    spheres = ", ".join(f"{{at: {at}, radius: 0.002}}" for at in places)
    rig = build(palpate.Scene.parse(SCENE.format(K=1400, B=0, spheres=spheres)))
    stiff = certify_all(rig.scene, K=1e6, rig=rig)[1]
    assert "2 of its spheres" in stiff.worst
    assert stiff.k_max == pytest.approx(certify_all(rig.scene, K=stiff.k_max, rig=rig)[1].k_max, rel=1e-3)


def test_postures_follow_the_path_with_closed_and_open_jaws():
    text = SCENE.format(K=400, B=0, spheres="").replace("spheres: []", "whole_tool: true")
    rig = build(palpate.Scene.parse(text.replace("]}\nstability", ", {t: 3, xyz: [0.005, 0, 0.004]}]}\nstability")))
    assert rig.path.times[-1] == 3.0
    start, half = postures(rig, (0.5,))
    tip = (rig.arms.X_WB @ rig.arms.follower.fk(rig.arms.q_follower0))[:3, 3]
    there = rig.path.positions_W[np.argmin(np.abs(rig.path.times - 0.5 * rig.path.times[-1]))]
    for (closed, opened), place in ((start, tip), (half, there)):
        np.testing.assert_allclose(closed.centres[0], place, atol=1e-9)
        gaps = [np.linalg.norm(one.centres[1] - one.centres[2]) for one in (closed, opened)]
        assert gaps[1] > gaps[0] + 0.003

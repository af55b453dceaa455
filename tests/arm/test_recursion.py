"""Our recursions for the kinematics and dynamics of serial arms, against Pinocchio's computeAllTerms."""

from pathlib import Path

import numpy as np
import pytest

from palpate import _core, _reference

FLAGS = Path("/proc/cpuinfo").read_text().split()
BUILDS = [name for name, flag in (("avx2", "avx2"), ("avx512", "avx512dq")) if flag in FLAGS]


def random_arm(joints: int, rng: np.random.Generator) -> str:
    """URDF of revolute and prismatic joints about random axes, with fixed links in between and a fixed branch."""

    def vector(x):
        return " ".join(f"{value:.17g}" for value in x)

    def link(name):
        m, c = rng.uniform(0.05, 2.0), rng.normal(0.0, 0.1, 3)
        a, b, d = rng.uniform(1e-4, 1e-2, 3)
        inertia = f'ixx="{b + d}" iyy="{a + d}" izz="{a + b}" ixy="0" ixz="0" iyz="0"'
        origin = f'<origin xyz="{vector(c)}" rpy="{vector(rng.normal(size=3))}"/>'
        return f'<link name="{name}"><inertial>{origin}<mass value="{m}"/><inertia {inertia}/></inertial></link>'

    def joint(name, kind, parent, child, axis):
        origin = f'<origin xyz="{vector(rng.normal(0.0, 0.2, 3))}" rpy="{vector(rng.normal(size=3))}"/>'
        limit = '<limit lower="-2" upper="2" effort="1" velocity="1"/>'
        return (
            f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>{origin}'
            f'<axis xyz="{vector(axis)}"/>{limit}</joint>'
        )

    parts, parent = ['<link name="base"/>'], "base"
    axes = [np.eye(3)[0], np.eye(3)[1], np.eye(3)[2], -np.eye(3)[2], *rng.normal(size=(4, 3))]
    for k in range(joints):
        axis = axes[rng.integers(len(axes))]
        kind = "prismatic" if rng.random() < 0.3 else "revolute"
        parts += [link(f"l{k}"), joint(f"j{k}", kind, parent, f"l{k}", axis / np.linalg.norm(axis))]
        parts += [link(f"f{k}"), joint(f"k{k}", "fixed", f"l{k}", f"f{k}", axis)]
        parts += [link(f"b{k}"), joint(f"i{k}", "revolute", f"l{k}", f"b{k}", axis)]
        parent = f"f{k}"
    return f'<robot name="random">{"".join(parts)}</robot>'


@pytest.mark.parametrize("joints", range(1, 9))
def test_random_chains_agree_with_pinocchio(joints):
    rng = np.random.default_rng(joints)
    for _ in range(5):
        xml, tip = random_arm(joints, rng), f"f{joints - 1}"
        arm, reference = _core.Arm(xml, "base", tip), _reference.AllTerms(xml, "base", tip)
        for _ in range(20):
            q, v = rng.uniform(-2, 2, joints), rng.normal(0, 2, joints)
            M, bias, G, J = reference.compute(q, v)
            ours = arm.dynamics(q, v)
            scale = max(1.0, np.abs(M).max(), np.abs(bias).max())
            assert np.abs(ours[0] - M).max() < 1e-12 * scale
            assert np.abs(ours[1] - bias).max() < 1e-12 * scale
            assert np.abs(arm.gravity(q) - G).max() < 1e-12 * scale
            assert np.abs(ours[3] - J).max() < 1e-12
            assert np.array_equal(arm.jacobian(q), ours[3])
            assert np.array_equal(arm.fk(q), ours[2])


@pytest.mark.parametrize("joints", range(1, 9))
def test_all_builds_return_the_same_bits(joints):
    rng = np.random.default_rng(20 + joints)
    xml, tip = random_arm(joints, rng), f"f{joints - 1}"
    for reach in (1e-3, 2.0, 1e3, 1e5, 1e7):  # beyond a million radians the C library computes the sines
        q, v = rng.uniform(-reach, reach, joints), rng.normal(0, 2, joints)
        portable = _core.recursion_by_kernel(xml, "base", tip, q, v, "portable")
        for name in BUILDS:
            assert _core.recursion_by_kernel(xml, "base", tip, q, v, name) == portable


@pytest.mark.parametrize("reach", [1e-3, 1.0, 3e4])
def test_sines_of_any_angle_are_those_of_numpy(reach):
    """One joint about z, whose Jacobian and pose are its sine and cosine."""
    inertia = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    joint = '<parent link="base"/><child link="l"/><axis xyz="0 0 1"/>'
    limit = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
    xml = (
        f'<robot name="one"><link name="base"/><link name="l">{inertia}</link>'
        f'<joint name="j" type="revolute">{joint}{limit}</joint></robot>'
    )
    arm = _core.Arm(xml, "base", "l")
    angles = np.concatenate([np.arange(-8, 9) * np.pi / 4, np.random.default_rng(3).uniform(-reach, reach, 1000)])
    for angle in angles:
        R = arm.fk([angle])[:3, :3]
        assert np.abs([R[0, 0] - np.cos(angle), R[1, 0] - np.sin(angle)]).max() < 4.5e-16


def test_shipped_arms_agree_with_pinocchio(arm, poses):
    reference = _reference.AllTerms(arm.urdf, *arm.frames)
    rng = np.random.default_rng(9)
    for q in poses:
        v = 3 * rng.normal(size=arm.n)
        M, bias, G, J = reference.compute(q, v)
        ours = arm.dynamics(q, v)
        for mine, theirs in ((ours[0], M), (ours[1], bias), (arm.gravity(q), G), (ours[3], J)):
            assert np.abs(mine - theirs).max() < 1e-12


def test_drift_is_the_rate_of_the_jacobian_times_the_velocity(arm, poses):
    """Reference: dJ/dt v by Richardson extrapolation along the motion."""
    rng = np.random.default_rng(10)
    for q in poses[:10]:
        v = rng.normal(size=arm.n)

        def slope(h, q=q, v=v):
            return (arm.jacobian(q + h * v) - arm.jacobian(q - h * v)) @ v / (2 * h)

        assert np.abs((4 * slope(1e-3) - slope(2e-3)) / 3 - arm.dynamics(q, v)[4]).max() < 1e-8

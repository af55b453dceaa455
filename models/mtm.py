"""The da Vinci master arm (MTM): its tables, masses and shapes. Sources: see generate.py."""

from __future__ import annotations

import math

import numpy as np
from parts import Body, Joint, Link, Visual, box, move, rod, standard_dh, urdf

# joint, alpha [deg], a, d [m], offset [deg], q_min, q_max of the RIGHT arm [rad], tau_max [N m], v_max [rad/s]
# v_max: the trajectory limits of the real controller (a hand may move the arm faster).
MTM_DH = [
    ("outer_yaw", 90, 0.0, 0.0, -90, -1.13446, 0.698132, 1.86083, math.pi / 2),
    ("shoulder_pitch", 0, 0.2794, 0.0, -90, -0.31416, 1.13446, 3.21662, math.pi / 2),
    ("elbow_pitch", -90, 0.3645, 0.0, 90, -0.872665, 0.610865, 1.95978, math.pi / 2),
    ("wrist_platform", 90, 0.0, 0.1506, 0, -1.6580, 3.5779, 0.30901, math.pi / 2),
    ("wrist_pitch", -90, 0.0, 0.0, 0, -1.6580, 3.2288, 0.09684, math.pi / 2),
    ("wrist_yaw", 90, 0.0, 0.0, -90, -0.785398, 0.785398, 0.09684, math.pi / 2),
    ("wrist_roll", 0, 0.0, 0.0, 90, -8.378, 8.378, 0.0229, 2 * math.pi),
]
# The left arm has mirrored limits of joints 1 and 4, and a slightly smaller range of the shoulder.
MTM_LEFT_LIMITS = {
    "outer_yaw": (-0.698132, 1.13446),
    "shoulder_pitch": (-0.261799, 1.13446),
    "wrist_platform": (-3.5779, 1.6580),
}

# CAD masses [kg] and centres of mass [m] in the standard-DH frame after each joint, right arm. The centre
# of mass of the upper arm is behind the shoulder because it includes the counterweight. For the left arm, z of the
# platform and y of the pitch link change sign (as p5 of identified arms does). The CAD's yaw link (0.05 kg) is split
# into yaw link and handle (0.02 kg on the roll axis, at the grip) with the same total mass and first moment.
MTM_CAD = {
    "upper_arm": (0.65, (-0.38, 0.0, 0.0)),
    "forearm": (0.04, (-0.25, 0.0, 0.0)),
    "platform": (0.14, (0.0, -0.084, -0.12)),
    "pitch_link": (0.04, (0.0, 0.036, -0.065)),
    "yaw_link": (0.03, (0.0, -0.025 * 5 / 3, 0.05 * 5 / 3)),
    "handle": (0.02, (0.0, 0.0, 0.0)),
}
# Inertia about the centre of mass in the link frame's axes [kg m^2]. Upper arm and forearm: identified magnitudes
# (IROS 2019), axes reordered; column and wrist: OURS, for bodies of that mass and size.
MTM_INERTIA = {
    "column": (0.010, 0.010, 0.012),
    "upper_arm": (0.01915, 0.00080, 0.01928),
    "forearm": (0.00718, 0.0020, 0.0080),
    "platform": (6e-4, 5e-4, 6e-4),
    "pitch_link": (1.2e-4, 8e-5, 1.2e-4),
    "yaw_link": (4e-5, 6e-5, 4e-5),
    "handle": (1.2e-5, 1.2e-5, 6e-6),
}
MTM_LINKS = ["column", "upper_arm", "forearm", "platform", "pitch_link", "yaw_link", "handle"]
GRIPPER_MAX = math.pi / 3


def mtm_visuals(m: float) -> dict[str, list[Visual]]:
    """Shapes per link; m = +1 right arm, -1 left arm (the gimbal is mirrored)."""
    return {
        "mtm_base": [
            box((0, 0.03, 0.235), (0.20, 0.24, 0.02), "dark"),
            rod((0, 0, 0.135), (0, 0, 0.225), 0.052, "steel"),
            box((0, 0.09, 0.19), (0.11, 0.09, 0.07), "shell"),
        ],
        "column": [  # z up, shoulder axis along x
            rod((0, 0, 0.045), (0, 0, 0.13), 0.046, "shell"),
            box((0, 0.03, 0.03), (0.10, 0.13, 0.07), "shell"),
            rod((-0.066, 0, 0), (0.066, 0, 0), 0.042, "steel"),
            rod((-0.035, 0.12, 0.03), (-0.035, 0.03, 0.03), 0.026, "dark"),
            rod((0.035, 0.12, 0.03), (0.035, 0.03, 0.03), 0.026, "dark"),
        ],
        "upper_arm": [  # at q = 0: x forward, y up, z right; the elbow is down -y
            rod((0, 0, -0.03), (0, 0, 0.03), 0.050, "dark"),
            box((0, -0.14, 0.022), (0.050, 0.27, 0.012), "shell"),
            box((0, -0.14, -0.022), (0.050, 0.27, 0.012), "shell"),
            box((0.014, -0.15, 0), (0.014, 0.20, 0.032), "accent"),
            box((0, 0.085, 0), (0.075, 0.085, 0.10), "dark"),
            rod((0, -0.2794, -0.036), (0, -0.2794, 0.036), 0.030, "steel"),
        ],
        "crank": [
            box((-0.05, 0, 0.045), (0.10, 0.026, 0.010), "steel"),
            rod((0, 0, 0.036), (0, 0, 0.052), 0.024, "steel"),
            rod((-0.1, 0, 0.036), (-0.1, 0, 0.054), 0.013, "dark"),
        ],
        "parallel_bar": [
            rod((0, 0, 0.045), (0, -0.2794, 0.045), 0.008, "steel"),
            rod((0, -0.2794, 0.036), (0, -0.2794, 0.054), 0.013, "dark"),
        ],
        "forearm": [  # at q = 0: forward along +y, up is -x
            box((0, -0.045, 0.036), (0.028, 0.12, 0.012), "steel"),
            rod((0, -0.02, 0), (0, 0.33, 0), 0.017, "shell"),
            rod((-0.026, 0.02, 0), (-0.026, 0.32, 0), 0.006, "steel"),
            box((-0.012, 0.02, 0), (0.045, 0.05, 0.04), "shell"),
            rod((0.03, 0.3645, 0), (-0.035, 0.3645, 0), 0.026, "dark"),
            box((-0.005, 0.325, 0), (0.04, 0.04, 0.036), "shell"),
        ],
        "platform": [  # z up; an L out to the side and up to the pitch pivot
            rod((0, 0, 0.026), (0, 0, 0.048), 0.028, "steel"),
            box((0, m * 0.072, 0.046), (0.034, 0.165, 0.016), "shell"),
            box((0, m * 0.148, 0.103), (0.034, 0.014, 0.13), "shell"),
            rod((0, m * 0.128, 0.1506), (0, m * 0.160, 0.1506), 0.021, "dark"),
        ],
        "pitch_link": [  # at q = 0: x forward, y up, z right; an L down and under the grip
            rod((0, 0, -m * 0.130), (0, 0, -m * 0.112), 0.019, "steel"),
            box((0, -0.042, -m * 0.118), (0.026, 0.105, 0.011), "shell"),
            box((0, -0.090, -m * 0.055), (0.026, 0.011, 0.137), "shell"),
            rod((0, -0.097, 0), (0, -0.078, 0), 0.018, "dark"),
        ],
        "yaw_link": [  # z up; an L backward and up to the roll axis
            rod((0, 0, -0.080), (0, 0, -0.070), 0.016, "steel"),
            box((-0.042, 0, -0.071), (0.095, 0.022, 0.009), "shell"),
            box((-0.085, 0, -0.036), (0.010, 0.022, 0.078), "shell"),
            rod((-0.098, 0, 0), (-0.070, 0, 0), 0.016, "dark"),
        ],
        "handle": [  # roll axis z, towards the operator; the grips reach forward, -z
            rod((0, 0, 0.072), (0, 0, 0.030), 0.0095, "brass"),
            box((0, 0, 0.032), (0.026, 0.018, 0.016), "grip"),
        ],
        "grip_upper": [
            box((0, 0.012, -0.030), (0.016, 0.005, 0.062), "grip"),
            rod((0, 0.0155, -0.052), (0, 0.0155, -0.046), 0.010, "accent"),
        ],
        "grip_lower": [
            box((0, -0.012, -0.030), (0.016, 0.005, 0.062), "grip"),
            rod((0, -0.0155, -0.052), (0, -0.0155, -0.046), 0.010, "accent"),
        ],
    }


def mtm(side: str) -> str:
    """The URDF of the "left" or "right" arm."""
    m = 1.0 if side == "right" else -1.0
    looks = mtm_visuals(m)
    parts: list[Link | Joint] = [Link("mtm_base", looks["mtm_base"])]
    parent, X = "mtm_base", np.eye(4)
    for (name, alpha, a, d, offset, lower, upper, tau, v), link in zip(MTM_DH, MTM_LINKS, strict=True):
        if side == "left":
            lower, upper = MTM_LEFT_LIMITS.get(name, (lower, upper))
        F = standard_dh(alpha, a, d, offset)
        if link in MTM_CAD:
            mass, com = MTM_CAD[link]
            mirror = {"platform": (1, 1, m), "pitch_link": (1, m, 1)}.get(link, (1, 1, 1))
            com_link = (F @ np.append(np.multiply(com, mirror), 1.0))[:3]
        else:
            mass, com_link = (
                2.0,
                np.array([0.0, 0.0, 0.03]),
            )  # OURS: its weight acts on no joint, because the axis is vertical
        parts.append(Joint(name, parent, link, X, "revolute", limits=(lower, upper, tau, v)))
        parts.append(Link(link, looks[link], Body(mass, tuple(com_link), MTM_INERTIA[link])))
        parent, X = link, F
    parts += [Joint("tip_mount", "handle", "tip", X), Link("tip")]
    # The parallelogram that drives the forearm: its crank turns with q2 + q3, its bar stays parallel to the upper arm.
    parts += [
        Joint("crank_hinge", "upper_arm", "crank", np.eye(4), "revolute", mimic=("elbow_pitch", 1.0)),
        Link("crank", looks["crank"]),
        Joint("bar_hinge", "crank", "parallel_bar", move(x=-0.1), "revolute", mimic=("elbow_pitch", -1.0)),
        Link("parallel_bar", looks["parallel_bar"]),
        # The grips are a passive hinge without motor; 0 = closed.
        Joint("gripper", "handle", "gripper_frame", move(z=0.03), "revolute", (1, 0, 0), (0.0, GRIPPER_MAX, 0.0, 20.0)),
        Link("gripper_frame"),
        Joint("grip_upper_hinge", "handle", "grip_upper", move(z=0.03), "revolute", (-1, 0, 0), mimic=("gripper", 0.5)),
        Link("grip_upper", looks["grip_upper"]),
        Joint("grip_lower_hinge", "handle", "grip_lower", move(z=0.03), "revolute", (1, 0, 0), mimic=("gripper", 0.5)),
        Link("grip_lower", looks["grip_lower"]),
    ]
    return urdf(f"mtm_{side}", parts)


MTM_YAML = """\
# Generated by models/generate.py: edit that script. MTM, {side} arm. Limits and masses: {name}.urdf.
name: {name}
urdf: {name}.urdf
base_frame: mtm_base   # L: z up, x left, y towards the mount of the arm
tip_frame: tip         # H: at the intersection of the four wrist axes
home: [0, 0, 0, 0, 0, 0, 0]   # rad; homing position of the real controller
platform: true         # joint 4 has its own controller, which keeps the gimbal away from its singularity
# q_joint = A q_motor. The motors of joints 2 and 3 sit at the base: motor 3 sets the forearm's absolute angle through
# the parallelogram, and the platform's cable runs over both. Source: sawIntuitiveResearchKit compute-ftmax.py.
coupling:
  - [1, 0, 0, 0, 0, 0, 0]
  - [0, 1, 0, 0, 0, 0, 0]
  - [0, -1, 1, 0, 0, 0, 0]
  - [0, 0.6697, -0.6697, 1, 0, 0, 0]
  - [0, 0, 0, 0, 1, 0, 0]
  - [0, 0, 0, 0, 0, 1, 0]
  - [0, 0, 0, 0, 0, 0, 1]
# A spring at the base carries part of the forearm's weight. Its potential is P = -torque sin(along . q) [N m], where
# along . q = q2 + q3 is the absolute angle of the forearm. Source of 0.54 N m: the CAD model of Lin et al., IROS 2019.
# That model applies it to joint 3 only, which is not conservative: moving joints 2 and 3 around a loop would generate
# energy. Here it acts on both joints, and on joint 2 it replaces that model's constant cable term (-0.33 N m). The
# wrist spring of that model (0.007 N m/rad) is left out because it is smaller than the friction of the wrist.
counterbalance: {{torque: 0.54, along: [0, 1, 1, 0, 0, 0, 0]}}
# Degrees of motor-side joint angle per encoder count. Source: sawIntuitiveResearchKit share/io/config-generator.py.
encoder_step_deg: [0.00141933, 0.00180433, 0.00150678, 0.00854701, 0.1696, 0.1696, 0.3393]
# Coulomb [N m] and viscous [N m s/rad] friction. Source: identified, Wang et al., IROS 2019, rounded.
coulomb: [0.049, 0.032, 0.043, 0.029, 0.007, 0.002, 0.001]
viscous: [0.049, 0.093, 0.062, 0.005, 0.001, 0.002, 0.0001]
# Rotor inertia times gear ratio squared [kg m^2], our estimate (not published): 1.0e-6 for the motors of joints 1-4,
# 5.0e-8 for those of the wrist, gears 63.41 49.88 59.73 10.53 33.16 33.16 16.58.
rotor_inertia: [4.0e-3, 2.5e-3, 3.6e-3, 1.1e-4, 5.5e-5, 5.5e-5, 1.4e-5]
"""

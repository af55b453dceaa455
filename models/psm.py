"""The da Vinci patient-side arm (PSM) with one of its instruments: tables and shapes. Sources: see generate.py."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from parts import Body, Joint, Link, Visual, ball, box, modified_dh, move, rod, urdf


@dataclass(frozen=True)
class Tool:
    """An instrument of the PSM. Source: sawIntuitiveResearchKit, share/tool/NAME_NUMBER.json; OURS marks estimates."""

    name: str
    """of the model: psm_NAME"""
    title: str
    pitch_to_yaw: float
    """distance between the axes of the wrist [m]"""
    jaw: tuple[float, float]
    """range of the jaws [rad]"""
    coupling: tuple[float, float, float]
    """motion of roll, pitch and yaw per motion of their motors [-]"""
    encoder_step: tuple[float, float, float]
    """of these joints: 0.00768574 deg of the motors times the coupling [deg]"""
    jaw_tip: float
    """distance from the yaw axis to the tip of the jaws [m]"""
    jaw_tip_source: str = ""


LND = Tool(
    name="lnd",
    title="large needle driver 400006",
    pitch_to_yaw=0.0091,
    jaw=(-0.698, 1.396),
    coupling=(1.5632, 1.0186, 0.6089),
    encoder_step=(0.0120144, 0.0078287, 0.0046798),
    jaw_tip=0.0102,
)
PROGRASP = Tool(
    name="prograsp",
    title="ProGrasp forceps 400093",
    pitch_to_yaw=0.0107,
    jaw=(-0.349, 1.396),
    coupling=(1.5631, 1.0, 0.5135),
    encoder_step=(0.0120136, 0.0076857, 0.0039466),
    jaw_tip=0.02,
    jaw_tip_source="; OURS: estimated",
)

# joint, kind, alpha [deg], a, d [m], offset [deg], q_min, q_max, tau_max [N m, N], v_max [rad/s, m/s] (v_max OURS)
PSM_DH = [
    ("yaw", "revolute", 90, 0.0, 0.0, 90, -1.588, 1.588, 3.3161, 4.0),
    ("pitch", "revolute", -90, 0.0, 0.0, -90, -0.925025, 0.925025, 3.3161, 4.0),
    ("insertion", "prismatic", 90, 0.0, -0.4318, 0, 0.0, 0.24, 9.8779, 0.8),
    ("roll", "revolute", 0, 0.0, 0.4162, 0, -4.538, 4.538, 0.33, 12.0),
    ("wrist_pitch", "revolute", -90, 0.0, 0.0, -90, -1.3963, 1.3963, 0.25, 12.0),
    ("wrist_yaw", "revolute", -90, 0.0, 0.0, -90, -1.3963, 1.3963, 0.20, 12.0),
]
PSM_TIP = np.array([[0, -1, 0, 0], [0, 0, 1, 0], [-1, 0, 0, 0], [0, 0, 0, 1]], dtype=float)
JAW_TAU = 0.16
PSM_LINKS = ["yaw_link", "pitch_link", "carriage", "shaft", "wrist", "tool"]
# Yaw, pitch and insertion: masses published for the Si (PSM_Si_physical.json); the rest OURS. The
# centres of mass of yaw and pitch include the counterweight: both joints are balanced at 120 mm of insertion.
PSM_BODIES = {
    "yaw_link": Body(0.994, (0.0, 0.0, 0.50), (8e-3, 8e-3, 6e-3)),
    "pitch_link": Body(2.060, (-0.00928, -0.0986, 0.0), (3e-2, 6e-3, 3e-2)),
    "carriage": Body(0.637, (0.03, 0.0, 0.0), (1.5e-3, 1.5e-3, 1e-3)),
    "shaft": Body(0.05, (0.0, 0.0, -0.21), (7e-4, 7e-4, 2e-6)),
    "wrist": Body(0.004, (0.005, 0.0, 0.0), (1e-7, 1e-7, 1e-7)),
    "tool": Body(0.003, (0.0, 0.004, 0.0), (1e-7, 1e-7, 1e-7)),
}
BACK = 0.516  # distance from the remote centre (RCM) to the parallelogram's pivot [m]


PSM_VISUALS: dict[str, list[Visual]] = {
    "psm_base": [  # RCM; the yaw axis runs along -y to the body
        rod((0, -0.74, 0), (0, -0.655, 0), 0.062, "dark"),
        box((0, -0.755, 0.05), (0.16, 0.03, 0.24), "steel"),
    ],
    "yaw_link": [  # x up, z along the yaw axis, away from the patient
        rod((0, 0, 0.655), (0, 0, 0.44), 0.055, "shell"),
        box((-0.01, 0, 0.555), (0.09, 0.15, 0.16), "shell"),
        rod((0, -0.088, BACK), (0, 0.088, BACK), 0.044, "steel"),
        box((0.0, 0, 0.43), (0.045, 0.06, 0.07), "accent"),
    ],
    "bar_back": [
        box((0.095, 0.066, 0), (0.22, 0.012, 0.042), "shell"),
        box((0.095, -0.066, 0), (0.22, 0.012, 0.042), "shell"),
        rod((0.19, -0.066, 0), (0.19, 0.066, 0), 0.018, "dark"),
        rod((0.10, -0.066, 0), (0.10, 0.066, 0), 0.018, "dark"),
    ],
    "bar_upper": [
        box((0, 0.048, -0.255), (0.026, 0.014, 0.51), "shell"),
        box((0, -0.048, -0.255), (0.026, 0.014, 0.51), "shell"),
    ],
    "bar_lower": [
        box((0, 0.030, -0.255), (0.022, 0.012, 0.51), "steel"),
        box((0, -0.030, -0.255), (0.022, 0.012, 0.51), "steel"),
    ],
    "pitch_link": [  # x back towards the body, y up along the instrument
        box((0.055, 0.275, 0), (0.035, 0.40, 0.062), "shell"),
        box((0.034, 0.30, 0), (0.010, 0.34, 0.030), "dark"),
        box((0.006, 0.19, 0), (0.07, 0.022, 0.116), "steel"),
        box((0.006, 0.10, 0), (0.07, 0.022, 0.080), "steel"),
        box((0.03, 0.062, 0), (0.06, 0.018, 0.030), "steel"),
        rod((0, 0.085, 0), (0, 0.050, 0), 0.0115, "steel"),
        rod((0, 0.055, 0), (0, -0.055, 0), 0.0058, "steel"),
        ball((0, 0, 0), 0.0075, "accent"),
    ],
    "carriage": [  # z down along the shaft; x back
        box((0.022, 0, -0.010), (0.030, 0.058, 0.075), "dark"),
        box((-0.006, 0, -0.022), (0.042, 0.064, 0.082), "shell"),
        box((-0.006, 0, -0.070), (0.034, 0.050, 0.018), "accent"),
    ],
    "shaft": [rod((0, 0, -0.41), (0, 0, -0.002), 0.0042, "dark"), ball((0, 0, -0.002), 0.0042, "steel")],
}


def _tool_visuals(tool: Tool) -> dict[str, list[Visual]]:
    """Shapes of wrist and jaws; the jaws are as long as the tool's."""
    longer, wrist = tool.jaw_tip - LND.jaw_tip, tool.pitch_to_yaw + 0.0001
    looks = {
        "wrist": [
            rod((0, 0, -0.0036), (0, 0, 0.0036), 0.0026, "steel"),
            box((0.5 * round(wrist, 4), 0, 0), (round(wrist, 4), 0.0046, 0.0052), "steel"),
        ],
        "tool": [rod((0, 0, -0.0030), (0, 0, 0.0030), 0.0024, "steel")],
    }
    colour = "brass" if tool is LND else "steel"
    for jaw, side in (("jaw_1", 1.0), ("jaw_2", -1.0)):
        looks[jaw] = [
            box((side * 0.0011, 0.0056 + 0.5 * longer, 0), (0.0018, 0.0094 + longer, 0.0034), colour),
            box((side * 0.0016, 0.0015, 0), (0.0026, 0.004, 0.0042), "steel"),
        ]
    return looks


def psm(tool: Tool) -> str:
    """Text of the URDF."""
    looks = PSM_VISUALS | _tool_visuals(tool)
    parts: list[Link | Joint] = [Link("psm_base", looks["psm_base"])]
    parent = "psm_base"
    for (name, kind, alpha, a, d, offset, lower, upper, tau, v), link in zip(PSM_DH, PSM_LINKS, strict=True):
        a = tool.pitch_to_yaw if name == "wrist_yaw" else a
        parts.append(Joint(name, parent, link, modified_dh(alpha, a, d, offset), kind, limits=(lower, upper, tau, v)))
        parts.append(Link(link, looks[link], PSM_BODIES[link]))
        parent = link
    parts += [Joint("tip_mount", "tool", "tip", PSM_TIP), Link("tip")]

    # The double parallelogram that keeps the remote centre is drawn only; it follows the pitch joint.
    def bar(name: str, on: str, X: np.ndarray, multiplier: float) -> list[Link | Joint]:
        return [
            Joint(f"{name}_hinge", on, name, X, "revolute", (0, 1, 0), mimic=("pitch", multiplier)),
            Link(name, looks[name]),
        ]

    parts += bar("bar_back", "yaw_link", move(z=BACK), 1.0)
    parts += bar("bar_upper", "bar_back", move(x=0.19), -1.0) + bar("bar_lower", "bar_back", move(x=0.10), -1.0)
    # Each jaw opens by half of the jaw angle; 0 = closed.
    parts += [
        Joint("jaw", "tool", "jaw_frame", np.eye(4), "revolute", limits=(*tool.jaw, JAW_TAU, 12.0)),
        Link("jaw_frame"),
        Joint("jaw_1_hinge", "tool", "jaw_1", np.eye(4), "revolute", (0, 0, -1), mimic=("jaw", 0.5)),
        Link("jaw_1", looks["jaw_1"]),
        Joint("jaw_2_hinge", "tool", "jaw_2", np.eye(4), "revolute", (0, 0, 1), mimic=("jaw", 0.5)),
        Link("jaw_2", looks["jaw_2"]),
    ]
    return urdf(f"psm_{tool.name}", parts)


_YAML = """\
# Generated by models/generate.py: edit that script. PSM with the {title}. Limits: psm_{name}.urdf.
name: psm_{name}
urdf: psm_{name}.urdf
base_frame: psm_base   # B: at the remote centre of motion; the tool points along -z at q = 0
tip_frame: tip         # T: on the wrist's yaw axis (control point of the real controller), z along the jaws
home: [0, 0, 0.12, 0, 0, 0]   # rad, rad, m, rad...: the tip {below:g} mm below the remote centre
remote_centre: true    # the instrument passes the body wall at the base frame
tool_type: "{number}"    # number with which the arm announces this instrument
jaw_tip: {jaw_tip:<6g}        # distance from T to the tip of the jaws [m]{jaw_tip_source}
# Joint-side resolution per encoder count, degrees (insertion: millimetres). Source: sawIntuitiveResearchKit
# config-generator.py; wrist motors 0.00768574 deg through the tool's coupling ({couplings}).
encoder_step_deg: [0.00044248, 0.00044248, 0, {steps}]
encoder_step_mm: [0, 0, 0.00129629, 0, 0, 0]
# Coulomb [N m, N] and viscous [N m s/rad, N s/m] friction at the joints. Source: identified, Wang et al., IROS 2019,
# rounded; for roll and wrist converted from the friction of their motors.
coulomb: [0.050, 0.067, 0.448, 0.003, 0.007, 0.005]
viscous: [0.091, 0.218, 1.204, 0.001, 0.002, 0.002]
# Rotor inertia at the joint [kg m^2, kg], identified by this project from their recordings (docs/dynamics.md).
rotor_inertia: [0.02, 0.02, 0.6, 6.0e-5, 1.0e-4, 1.0e-4]
# Spheres for contact of the whole tool: jaws, wrist and the last 70 mm of the shaft (radius 4.2 mm).
spheres:
{spheres}# Capsules for contact with another instrument: jaws, wrist and the whole shaft.
capsules:
{capsules}"""


def psm_yaml(tool: Tool) -> str:
    """Text of the model file."""
    end = round(tool.jaw_tip - 0.0017, 4)  # centre of the last sphere of a jaw
    sides = (("jaw_1", 0.0011), ("jaw_2", -0.0011))
    along = [end] if tool is LND else [end, round(0.55 * end, 4)]
    spheres = [(jaw, (side, y, 0.0), 0.0017) for y in along for jaw, side in sides]
    spheres.append(("wrist", (0.0045, 0.0, 0.0), 0.0030))
    spheres += [("shaft", (0.0, 0.0, -0.002 - 0.0062 * k), 0.0042) for k in range(15 - len(spheres))]  # 1.5 radii apart
    capsules = [(jaw, (0.0, 0.0, 0.0), (side, end, 0.0), 0.0017) for jaw, side in sides]
    capsules.append(("wrist", (0.0, 0.0, 0.0), (tool.pitch_to_yaw, 0.0, 0.0), 0.0030))
    capsules.append(("shaft", (0.0, 0.0, -0.41), (0.0, 0.0, -0.002), 0.0042))
    return _YAML.format(
        title=tool.title,
        name=tool.name,
        number=tool.title.rsplit(" ", 1)[1],
        below=1e3 * (0.12 - 0.4318 + 0.4162 + tool.pitch_to_yaw),
        jaw_tip=tool.jaw_tip,
        jaw_tip_source=tool.jaw_tip_source,
        couplings=", ".join(f"{c:g}" for c in tool.coupling),
        steps=", ".join(f"{step:.7f}" for step in tool.encoder_step),
        spheres="".join(
            f"  - {{link: {link}, at: [{x:g}, {y:g}, {z:g}], radius: {radius:g}}}\n"
            for link, (x, y, z), radius in spheres
        ),
        capsules="".join(
            f"  - {{link: {link}, from: [{', '.join(f'{x:g}' for x in a)}], to: [{', '.join(f'{x:g}' for x in b)}], "
            f"radius: {radius:g}}}\n"
            for link, a, b, radius in capsules
        ),
    )

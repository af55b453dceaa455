"""The da Vinci endoscope arm (ECM): tables and shapes. Sources: see generate.py."""

from __future__ import annotations

import numpy as np
from parts import Body, Joint, Link, Visual, ball, box, modified_dh, rod, rot, urdf

# joint, kind, alpha [deg], a, d [m], offset [deg], q_min, q_max, tau_max [N m, N], v_max [rad/s, m/s] (v_max OURS)
ECM_DH = [
    ("yaw", "revolute", 90, 0.0, 0.0, 90, -1.5708, 1.5708, 26.93208, 1.5),
    ("pitch", "revolute", -90, 0.0, 0.0, -90, -0.76794, 1.1344, 26.93208, 1.5),
    ("insertion", "prismatic", 90, 0.0, -0.3822, 0, 0.0, 0.255, 80.6589483, 0.4),
    ("roll", "revolute", 0, 0.0, 0.3829, 0, -1.552, 1.552, 0.87658808, 3.0),
]
ECM_TIP = rot("z", 90)  # OURS: of a straight endoscope; z looks along it
ECM_LINKS = ["yaw_link", "pitch_link", "carriage", "endoscope"]
# OURS, but for the endoscope's mass (HD, 2.5 kg with its cable in the real controller, half of it here).
ECM_BODIES = {
    "yaw_link": Body(1.5, (0.0, 0.0, 0.50), (1e-2, 1e-2, 1e-2)),
    "pitch_link": Body(3.0, (-0.009, -0.10, 0.0), (4e-2, 1e-2, 4e-2)),
    "carriage": Body(0.8, (0.03, 0.0, 0.0), (2e-3, 2e-3, 2e-3)),
    "endoscope": Body(1.2, (0.0, 0.0, -0.25), (6e-3, 6e-3, 1e-4)),
}
ECM_VISUALS: dict[str, list[Visual]] = {
    "ecm_base": [rod((0, -0.70, 0), (0, -0.62, 0), 0.070, "dark")],
    "yaw_link": [rod((0, 0, 0.62), (0, 0, 0.42), 0.060, "shell"), box((0, 0, 0.40), (0.06, 0.07, 0.07), "accent")],
    "pitch_link": [box((0.06, 0.25, 0), (0.04, 0.40, 0.07), "shell")],
    "carriage": [box((0.045, 0.0, 0.02), (0.06, 0.07, 0.09), "shell")],
    "endoscope": [rod((0, 0, -0.36), (0, 0, 0), 0.006, "steel"), ball((0, 0, 0), 0.0062, "dark")],
}


def ecm() -> str:
    """The URDF."""
    parts: list[Link | Joint] = [Link("ecm_base", ECM_VISUALS["ecm_base"])]
    parent = "ecm_base"
    for (name, kind, alpha, a, d, offset, lower, upper, tau, v), link in zip(ECM_DH, ECM_LINKS, strict=True):
        parts.append(Joint(name, parent, link, modified_dh(alpha, a, d, offset), kind, limits=(lower, upper, tau, v)))
        parts.append(Link(link, ECM_VISUALS[link], ECM_BODIES[link]))
        parent = link
    parts += [Joint("tip_mount", "endoscope", "tip", np.asarray(ECM_TIP)), Link("tip")]
    return urdf("ecm", parts)


ECM_YAML = """\
# Written by models/generate.py: edit there. ECM, classic, straight endoscope. Limits: ecm.urdf.
name: ecm
urdf: ecm.urdf
base_frame: ecm_base   # the remote centre of motion; the endoscope leaves along -z at q = 0
tip_frame: tip
home: [0, 0, 0.1, 0]   # rad, rad, m, rad
remote_centre: true
"""

"""A generic arm of six axes with a spherical wrist: an example of an arm that is nobody's, as leader or follower.

All numbers are OURS: a light desk-top arm with a reach of half a metre, masses of aluminium tubes and small motors.
"""

from __future__ import annotations

from parts import Body, Joint, Link, Visual, ball, move, rod, urdf

UPPER, FOREARM, HAND, BASE = 0.25, 0.22, 0.06, 0.15  # [m]

# joint, parent, child, its origin, axis, q_min, q_max [rad], tau_max [N m], v_max [rad/s]
CHAIN = [
    ("waist", "base", "column", move(z=0.08), (0, 0, 1), -2.9, 2.9, 8.0, 4.0),
    ("shoulder", "column", "upper_arm", move(z=BASE - 0.08), (0, 1, 0), -1.9, 1.9, 8.0, 4.0),
    ("elbow", "upper_arm", "forearm", move(z=UPPER), (0, 1, 0), -0.2, 2.7, 5.0, 4.0),
    ("forearm_roll", "forearm", "roll_link", move(z=FOREARM), (0, 0, 1), -3.0, 3.0, 1.5, 6.0),
    ("wrist_pitch", "roll_link", "pitch_link", move(), (0, 1, 0), -2.1, 2.1, 1.5, 6.0),
    ("wrist_roll", "pitch_link", "hand", move(), (0, 0, 1), -6.2, 6.2, 1.0, 8.0),
]
BODIES = {
    "column": Body(0.60, (0, 0, 0.04), (1e-3, 1e-3, 6e-4)),
    "upper_arm": Body(0.50, (0, 0, 0.11), (3.0e-3, 3.0e-3, 2.5e-4)),
    "forearm": Body(0.30, (0, 0, 0.10), (1.4e-3, 1.4e-3, 1.2e-4)),
    "roll_link": Body(0.10, (0, 0, -0.02), (6e-5, 6e-5, 4e-5)),
    "pitch_link": Body(0.06, (0, 0, 0.01), (3e-5, 3e-5, 2e-5)),
    "hand": Body(0.06, (0, 0, 0.04), (3e-5, 3e-5, 2e-5)),
}
SHAPES: dict[str, list[Visual]] = {
    "base": [rod((0, 0, 0), (0, 0, 0.08), 0.06, "dark")],
    "column": [rod((0, 0, 0), (0, 0, 0.08), 0.045, "shell")],
    "upper_arm": [
        ball((0, 0, 0), 0.045, "steel"),
        rod((0, 0, 0), (0, 0, UPPER), 0.028, "shell"),
        ball((0, 0, UPPER), 0.036, "steel"),
    ],
    "forearm": [rod((0, 0, 0), (0, 0, FOREARM - 0.03), 0.023, "shell")],
    "roll_link": [ball((0, 0, 0), 0.028, "steel")],
    "pitch_link": [rod((0, 0, 0), (0, 0, 0.035), 0.018, "accent")],
    "hand": [rod((0, 0, 0.035), (0, 0, HAND), 0.012, "grip")],
}

SIX_AXIS_YAML = """\
# Written by models/generate.py: edit there. A generic light arm of six axes; every number is ours.
name: six_axis
urdf: six_axis.urdf
tip_frame: tip                       # z leaves the hand along its last axis
home: [0, 0.3, 1.5, 0, 1.34, 0]      # rad; the hand points down
encoder_step_deg: [0.002, 0.002, 0.002, 0.01, 0.01, 0.01]
coulomb: [0.03, 0.03, 0.02, 0.005, 0.005, 0.003]     # N m
viscous: [0.03, 0.03, 0.02, 0.002, 0.002, 0.001]     # N m s/rad
rotor_inertia: [2.0e-3, 2.0e-3, 1.0e-3, 5.0e-5, 5.0e-5, 2.0e-5]   # kg m^2
"""

DELTA_YAML = """\
# Written by models/generate.py: edit there. A desk-top delta of the size of haptic devices; every number is ours.
name: delta
device: delta                # three driven arms, a platform that never turns: core/palpate/arm/delta.hpp
parameters:
  base_radius: 0.10          # of the hips' circle [m]
  platform_radius: 0.03      # of the rods' circle on the platform [m]
  upper: 0.13                # driven arm [m]
  rod: 0.26                  # [m]
  upper_mass: 0.08           # [kg]
  rod_mass: 0.03             # the pair of one arm [kg]
  platform_mass: 0.12        # with the handle [kg]
  torque_max: 1.0            # [N m]
  q_min: -0.7                # [rad], below the plane of the hips
  q_max: 1.3
home: [0.3, 0.3, 0.3]        # rad
encoder_step_deg: [0.01, 0.01, 0.01]
coulomb: [0.01, 0.01, 0.01]  # N m
viscous: [0.005, 0.005, 0.005]
rotor_inertia: [2.0e-4, 2.0e-4, 2.0e-4]   # kg m^2
"""


def six_axis() -> str:
    """The URDF."""
    parts: list[Link | Joint] = [Link("base", SHAPES["base"])]
    for name, parent, child, X, axis, q_min, q_max, tau_max, v_max in CHAIN:
        parts.append(Link(child, SHAPES[child], BODIES[child]))
        parts.append(Joint(name, parent, child, X, "revolute", axis, (q_min, q_max, tau_max, v_max)))
    parts += [Link("tip"), Joint("tip_mount", "hand", "tip", move(z=HAND))]
    return urdf("six_axis", parts)

"""Glossary of the report, for readers who do not know the paper."""

GLOSSARY = {
    "Leader (MTM)": "The arm that the surgeon holds: a da Vinci master tool manipulator, here simulated with its "
    "weight, friction and encoders.",
    "Follower (PSM)": "The arm at the patient that carries the instrument, here simulated.",
    "Tool tip x": "Position of the instrument's tip. In contact it lies inside the surface.",
    "Spherical proxy region (SPR)": "The sphere at the tool tip that touches the objects.",
    "Proxy x_d": "A point that follows the tool but stays on the surface: the position that the tool would have if the "
    "organ were hard.",
    "Deflection δx": "Vector from the tool to the proxy, x_d − x. It points out of the organ, and the spring pulls "
    "along it.",
    "Penetration": "Length of the deflection along the surface normal: the depth of the tool in the organ.",
    "Rendered force": "Force on the hand that the controller commands to the leader's motors.",
    "Load cell": "A simulated force sensor between hand and handle. It measures the actual force on the hand, which "
    "includes friction and inertia of the arm.",
    "Force cap": "Largest force that the safety stage commands. The rate cap limits how fast the force changes.",
    "Energy ledger": "Sums the energy that the rendered force took from the hand. A passive surface takes energy; if "
    "the sum is negative, the device has generated energy.",
    "Tick": "One round of the haptic cycle, from measured state to torque; usually 1000 per second.",
    "p50, p99, p99.9": "Percentiles: 50 %, 99 %, 99.9 % of the values are smaller.",
    "Lockstep, real time": "A lockstep run computes as fast as possible and gives the same bytes every time. A "
    "real-time run follows the clock and measures its lateness.",
    "W, L, H": "Frames: the world; the leader's base; the handle. A force in L is the paper's spatial force (green), "
    "in H its body force (red).",
}

"""The words of the report, for somebody who reads it first and the paper never."""

GLOSSARY = {
    "Leader (MTM)": "The arm the surgeon holds: a da Vinci master tool manipulator. Here simulated, with its weight, "
    "friction and encoders.",
    "Follower (PSM)": "The arm at the patient that carries the instrument. Here simulated.",
    "Tool tip x": "Where the instrument is. Deep in contact it lies inside the surface.",
    "Proxy x_d": "A point that follows the tool but may not enter the surface: where the tool would be if the organ "
    "were hard.",
    "Deflection δx": "From the tool to the proxy, x_d − x. It points out of the organ; the spring pulls along it.",
    "Penetration": "Length of the deflection along the surface normal: how deep the tool is inside.",
    "Rendered force": "What the controller commands the leader's motors to let the hand feel.",
    "Load cell": "A force sensor between hand and handle. Only a simulation has one here; it shows what really "
    "arrives, friction and inertia of the arm included.",
    "Force cap": "The safety stage never commands more than this, nor lets the force grow faster than its rate cap.",
    "Energy ledger": "Adds up what the rendered force took from the hand. A passive surface only takes; below zero "
    "the device has pushed by itself.",
    "Tick": "One round of the haptic cycle: state in, torque out. Usually a thousand a second.",
    "p50, p99, p99.9": "Half, 99 %, 99.9 % of the values are smaller. p99 says how bad the bad ones are.",
    "Lockstep, real time": "Lockstep computes as fast as it can and gives the same bytes every time. Real time keeps "
    "the pace of the clock and measures how well it does.",
    "W, L, H": "Frames: the world; the leader's base; the handle. A force in L is the paper's spatial force (green), "
    "in H its body force (red).",
}

"""A synthetic run with known results: a tool presses 4 mm into a floor at z = 0, slides along x, and retracts.

The spring force is K * depth along +z while z < 0; other columns have smooth values, so that none is empty.
"""

from __future__ import annotations

import numpy as np

from palpate.record.ticks import TICK_DOUBLES, Ticks, as_ticks

K = 500.0  # [N/m]
DEPTH = 0.004  # largest depth [m]
B = 2.0  # [N s/m]


def run(seconds: float = 4.0, rate: float = 1000.0) -> Ticks:
    n = round(seconds * rate)
    t = np.arange(n) / rate
    s = t / seconds
    rng = np.random.default_rng(7)
    ticks = as_ticks(np.zeros((n, TICK_DOUBLES)))
    height = np.interp(s, [0, 0.25, 0.4, 0.75, 0.9, 1], [0.02, 0.0, -DEPTH, -DEPTH, 0.0, 0.02])  # tool [m]
    along = 0.05 * np.clip((s - 0.4) / 0.35, 0, 1)
    depth = np.maximum(0.0, -height)
    touching = depth > 0
    down = -np.gradient(height, t)
    ticks["t"] = t
    ticks["q"] = 0.3 * np.sin(t[:, None] + np.arange(7))
    ticks["v"] = 0.3 * np.cos(t[:, None] + np.arange(7))
    ticks["p_WT"] = np.stack([along, 0.01 * np.sin(3 * t), height], axis=1)
    ticks["p_WT_goal"] = ticks["p_WT"]
    ticks["p_WP"] = ticks["p_WT"] + np.outer(depth, [0, 0, 1])
    ticks["p_LH"] = ticks["p_WT"] * 2 + [0, -0.36, -0.13]
    ticks["p_hand_L"] = ticks["p_LH"] - np.outer(depth, [0, 0, 3])
    ticks["v_LH"] = np.gradient(ticks["p_LH"], t, axis=0)
    ticks["quat_LH"] = ticks["quat_WT"] = [0.5, -0.5, 0.5, -0.5]
    ticks["q_follower"][:, :6] = 0.1 * np.sin(t[:, None] * np.arange(1, 7))
    ticks["normal"] = np.outer(touching, [0, 0, 1])
    ticks["delta_x"] = np.outer(depth, [0, 0, 1])
    ticks["depth"] = depth
    ticks["contacts"] = touching
    ticks["touch_force"][:, 0] = K * depth
    ticks["p_WC"][:, :2] = np.where(touching[:, None], ticks["p_WT"][:, :2], 0.0)
    ticks["F_spring_W"] = K * ticks["delta_x"]
    ticks["F_damping_W"] = np.outer(B * down * touching, [0, 0, 1])
    ticks["F_T_W"] = ticks["F_spring_W"] + ticks["F_damping_W"]
    ticks["F_H_L"] = ticks["F_T_W"]
    ticks["F_H_H"] = ticks["F_T_W"][:, [1, 2, 0]]
    ticks["F_cell_L"] = ticks["F_H_L"] + 0.02 * rng.normal(size=(n, 3))
    ticks["tau_force"] = 0.1 * ticks["F_H_L"][:, [2, 2, 2, 0, 0, 0, 0]]
    ticks["tau_gravity"] = [0.0, 0.5, 0.3, 0.05, 0.02, 0.01, 0.0] + 0.05 * np.sin(t)[:, None]
    ticks["tau"] = ticks["tau_force"] + ticks["tau_gravity"]
    power_in = np.einsum("ij,ij->i", -ticks["F_H_L"], ticks["v_LH"])
    ticks["energy_port"] = np.cumsum(power_in) / rate
    ticks["energy_spring"] = 0.5 * K * depth**2
    ticks["energy_damping"] = np.cumsum(B * down**2 * touching) / rate
    ticks["cycle_us"] = rng.gamma(9.0, 0.6, n)
    ticks["lateness_us"] = rng.gamma(2.0, 1.5, n)
    return ticks

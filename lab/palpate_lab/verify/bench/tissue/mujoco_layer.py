"""The same layer in MuJoCo's flex, for comparison: force of a sphere at a depth, and time of a step."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array
from palpate.world.tissue import Tissue

STEP = 1e-3  # [s]


def model(soft: Tissue, fixed: npt.NDArray[np.bool_], young: float, poisson: float, radius: float, start: Array) -> Any:
    """A MuJoCo model of a body with fixed nodes (n,), and a sphere whose centre starts at ``start`` (3,) [m]."""
    import mujoco

    nodes, tets = soft.nodes, soft.tets
    points = " ".join(f"{x:.9g}" for x in nodes.ravel())
    elements = " ".join(str(i) for i in tets.ravel())
    pinned = " ".join(str(i) for i in np.flatnonzero(fixed))
    mass = 1000.0 * float(np.abs(np.linalg.det(nodes[tets[:, 1:]] - nodes[tets[:, :1]])).sum()) / 6.0
    place = " ".join(f"{x:.9g}" for x in start)
    return mujoco.MjModel.from_xml_string(f"""
<mujoco>
  <option timestep="{STEP}" gravity="0 0 0" integrator="discrete"/>
  <size memory="512M"/>
  <worldbody>
    <body name="tool" mocap="true" pos="{place}">
      <geom type="sphere" size="{radius}" contype="1" conaffinity="1" condim="1"/>
    </body>
    <flexcomp name="layer" type="direct" dim="3" mass="{mass}" radius="0.0001" point="{points}" element="{elements}">
      <pin id="{pinned}"/>
      <contact condim="1" selfcollide="none" solref="0.004 1"/>
      <elasticity young="{young}" poisson="{poisson}" damping="0.02"/>
    </flexcomp>
  </worldbody>
</mujoco>""")


def press(built: Any, radius: float, depth: float, at: tuple[float, float]) -> tuple[float, list[float]]:
    """Force [N] on a sphere that is pressed by ``depth`` [m] at (x, y) [m], and the times of the steps [s].

    The sphere goes down within 0.3 s and rests for 0.2 s.
    """
    import mujoco

    data = mujoco.MjData(built)
    times, forces = [], []
    for k in range(500):
        s = min(k / 300.0, 1.0)
        data.mocap_pos[0] = [at[0], at[1], radius + 1e-3 - (depth + 1e-3) * s * s * (3.0 - 2.0 * s)]
        begin = time.perf_counter()
        mujoco.mj_step(built, data)
        times.append(time.perf_counter() - begin)
        total = np.zeros(3)
        for i in range(data.ncon):
            wrench = np.zeros(6)
            mujoco.mj_contactForce(built, data, i, wrench)
            total += data.contact[i].frame.reshape(3, 3).T @ wrench[:3]
        forces.append(float(np.linalg.norm(total)))
    return float(np.mean(forces[-100:])), times

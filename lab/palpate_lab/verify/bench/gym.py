"""`palpate bench gym`: speed of the environments of Gymnasium, with a bare arm of MuJoCo as control."""

from __future__ import annotations

import os
import time
from typing import TypedDict

import numpy as np

from palpate.base.sweep.local import cores

_JOINTS = 7
_ACTIONS = 1000  # drawn beforehand: fewer than an episode has would drift to the limits of the motion
_VARY = {"objects.0.stiffness": (200.0, 600.0)}  # drawn at each reset
_LINK = '<geom type="capsule" size="0.01" fromto="0 0 0 0 0 -0.1"/>'
_ARM = '<body pos="0 0 -0.1"><joint axis="{axis}"/>' + _LINK + "{inner}</body>"


class Figures(TypedDict):
    """Result of the benchmark. The keys are the documented contract of ``--json``."""

    instruments: int
    substeps: int
    step_ms: float
    workers: int
    steps_per_s: float
    cpu_us_per_step: float
    control_joints: int
    control_steps_per_s: float
    control_cpu_us_per_step: float
    ratio_to_control: float
    reset_ms: float
    load: float


def run(instruments: int = 64, substeps: int = 20, seconds: float = 5.0) -> Figures:
    """Step environments of the scene `palpation` with random actions for some seconds, then the control.

    A step is an action: `substeps` ticks of 1 ms of the whole haptic cycle. Episodes end after 5 s of simulated time
    and begin anew, as in a training.
    """
    from palpate.gym import PalpateVectorEnv
    from palpate.gym.world import RATE

    many = PalpateVectorEnv(instruments, "palpation", substeps=substeps, vary=_VARY)
    many.reset(seed=0)
    before = time.process_time()
    many.reset(seed=0)
    reset = time.process_time() - before
    rng = np.random.default_rng(0)
    low, high = many.instruments.low_high
    actions = [rng.uniform(low, high, (instruments, 6)) for _ in range(_ACTIONS)]
    began, used, steps = time.perf_counter(), time.process_time(), 0
    while time.perf_counter() - began < seconds:
        many.step(actions[steps % _ACTIONS])
        steps += 1
    took, used = time.perf_counter() - began, time.process_time() - used
    many.close()
    control, control_cpu = _control(substeps, min(seconds, 2.0))
    cpu = 1e6 * used / (steps * instruments)
    return Figures(
        instruments=instruments,
        substeps=substeps,
        step_ms=1e3 * substeps / RATE,
        workers=cores(),
        steps_per_s=steps * instruments / took,
        cpu_us_per_step=cpu,
        control_joints=_JOINTS,
        control_steps_per_s=control,
        control_cpu_us_per_step=control_cpu,
        ratio_to_control=cpu / control_cpu if control_cpu > 0.0 else 0.0,
        reset_ms=1e3 * reset / instruments,
        load=os.getloadavg()[0],
    )


def _control(substeps: int, seconds: float) -> tuple[float, float]:
    """Steps per second of a bare arm of MuJoCo on one core, and processor time of one [us]; 0 without MuJoCo."""
    try:
        import mujoco
    except ImportError:
        return 0.0, 0.0
    inner = ""
    for k in range(_JOINTS):
        inner = _ARM.format(axis=("1 0 0", "0 1 0", "0 0 1")[k % 3], inner=inner)
    text = f'<mujoco><option timestep="0.001"><flag contact="disable"/></option><worldbody>{inner}</worldbody></mujoco>'
    model = mujoco.MjModel.from_xml_string(text)
    data, steps, began, used = mujoco.MjData(model), 0, time.perf_counter(), time.process_time()
    while time.perf_counter() - began < seconds:
        mujoco.mj_step(model, data, nstep=substeps)
        steps += 1
    return steps / (time.perf_counter() - began), 1e6 * (time.process_time() - used) / steps

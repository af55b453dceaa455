"""A simulated dVRK without ROS: arms, console, pedals and teleoperations, addressed by their topic names.

    robot = palpate.simulators.dvrk.system(("MTMR", "PSM1"))
    robot.send("MTMR", "state_command", "home")
    robot.step(3 * 10_000)                                # 10 s; one tick is a third of a millisecond
    robot.send("MTMR", "body/servo_cf", [0, 0, 1, 0, 0, 0])
    robot.state("MTMR")["measured_cp"]                    # the measurement that the topic would publish
    robot.events()                                        # events since the last call

Some topics exist in the simulation only. `hand/servo_cp`, `hand/servo_cf`, `hand/gripper` and `hand/free` simulate a
hand on the handle of an MTM. `tool/servo_cf` is a force on the tip of a PSM: it moves a driven PSM, and otherwise only
appears in the measured torques. `emulate_fault` triggers a fault, `emulate_arm_clutch` presses the button on a PSM or
the ECM, and `emulate_*` of `footpedals` presses a pedal.

Further components: `SUJ/ARM`, the setup joints that carry a PSM or the ECM (OURS: six joints; at zero the base is where
it was configured), `SUJ` for all of them, `MTML_MTMR_ECM`, the camera's teleoperation, and `endoscope_focus`.

The parameters of the arms are those of `models/`. The parameters of their controllers are those of
sawIntuitiveResearchKit 2.4 unless marked OURS (chosen for this simulation).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from palpate import _dvrk
from palpate.arm import Arm, models_folder
from palpate.base.errors import ArmError

#: Names of the arms that can be simulated.
ARMS = ("MTMR", "MTML", "PSM1", "PSM2", "PSM3", "ECM")
#: Default teleoperations (leader, follower), created if both arms are present.
TELEOPS = (("MTMR", "PSM1"), ("MTML", "PSM2"))

_TOOL = "LARGE_NEEDLE_DRIVER:400006[12]"
_DEG = math.pi / 180.0


def _mtm(name: str) -> _dvrk.ArmSpec:
    arm = Arm.mtm("right" if name == "MTMR" else "left")
    spec = _dvrk.ArmSpec(name, "mtm", arm)
    spec.leader = arm.leader_options()
    spec.P = np.array([100.0, 80.0, 80.0, 3.0, 1.0, 0.4, 0.15])
    spec.D = np.array([10.0, 5.0, 5.0, 0.35, 0.028, 0.015, 0.005])
    spec.tracking_error = _DEG * np.array([10.0, 10.0, 10.0, 30.0, 30.0, 30.0, 30.0])  # OURS: the last four
    spec.v_max = _DEG * np.array([90.0] * 6 + [360.0])
    spec.a_max = _DEG * np.array([45.0] * 6 + [360.0])
    spec.start = spec.home = arm.home
    return spec


def _psm(name: str, *, driven: bool) -> _dvrk.ArmSpec:
    arm = Arm.psm("lnd")
    spec = _dvrk.ArmSpec(name, "psm", arm)
    spec.dynamic = driven
    spec.leader, spec.follower = arm.leader_options(), arm.follower_options()
    spec.P = np.array([120.0, 120.0, 6000.0, 6.0, 6.0, 6.0])
    spec.D = np.array([6.0, 5.0, 200.0, 0.09, 0.09, 0.09])
    spec.has_gravity_model = driven  # OURS: the real PSM is balanced, ours is where it was designed to be
    spec.tracking_error = np.array([20 * _DEG, 20 * _DEG, 0.02, 35 * _DEG, 35 * _DEG, 35 * _DEG])
    spec.v_max = np.array([90 * _DEG, 90 * _DEG, 0.2, *[1080 * _DEG] * 3])
    spec.a_max = np.array([90 * _DEG, 90 * _DEG, 0.2, *[720 * _DEG] * 3])
    spec.start = spec.home = arm.home
    spec.cannula_link = arm.link_names.index("wrist")
    spec.jaw_min, spec.jaw_max = arm.jaw_range
    spec.jaw_v_max, spec.jaw_a_max = 1080 * _DEG, 720 * _DEG
    spec.tool_type = _TOOL
    return spec


def _ecm(name: str) -> _dvrk.ArmSpec:
    arm = Arm.load(models_folder() / "ecm.yaml")
    spec = _dvrk.ArmSpec(name, "ecm", arm)
    spec.dynamic = False
    spec.follower = arm.follower_options()
    spec.has_gravity_model = False
    spec.tracking_error = np.array([20 * _DEG, 20 * _DEG, 0.02, 20 * _DEG])  # OURS
    spec.v_max = np.array([30 * _DEG, 30 * _DEG, 0.05, 30 * _DEG])  # OURS
    spec.a_max = np.array([90 * _DEG, 90 * _DEG, 0.05, 90 * _DEG])  # OURS
    spec.start = spec.home = arm.home
    return spec


def arm(name: str, *, driven: bool = False) -> _dvrk.ArmSpec:
    """Specification of an arm, which may be changed before it is passed to `system`.

    driven: True if the joints of a PSM are moved by torques, as those of an MTM; False if they follow their servo
        exactly, whatever the torques.

    Raises:
        ArmError: the name is not in `ARMS`.
    """
    if name in ("MTMR", "MTML"):
        return _mtm(name)
    if name in ("PSM1", "PSM2", "PSM3"):
        return _psm(name, driven=driven)
    if name == "ECM":
        return _ecm(name)
    raise ArmError(f"the simulated dVRK has no arm {name!r}", mend=f"arms: {', '.join(ARMS)}")


def system(
    arms: Sequence[str | _dvrk.ArmSpec] = ("MTMR", "MTML", "PSM1", "PSM2", "ECM"),
    *,
    driven: bool = False,
    base_frames: Mapping[str, ArrayLike] | None = None,
    teleops: Sequence[_dvrk.TeleopSpec] | None = None,
    head_sensor: bool = False,
) -> _dvrk.System:
    """A simulated dVRK with these arms (names or specifications from `arm`), powered off.

    base_frames: pose (4, 4) of an arm's own base in the frame of its `measured_cp`; default: identity.
    teleops: default: those of `TELEOPS` whose arms are both present.
    head_sensor: True if a head sensor reports the operator's presence, set by `emulate_operator_present` of `console`,
        and the coag pedal only itself; False if the coag pedal reports presence.

    Raises:
        ArmError: an arm is unknown, or named twice.
    """
    specs = [arm(a, driven=driven) if isinstance(a, str) else a for a in arms]
    names = [spec.name for spec in specs]
    for name in names:
        if names.count(name) > 1:
            raise ArmError(f"the arm {name!r} is named {names.count(name)} times", mend="name every arm once")
    for name, frame in (base_frames or {}).items():
        if name not in names:
            raise ArmError(f"there is no arm {name!r} to give a base frame", mend=f"arms: {', '.join(names)}")
        specs[names.index(name)].base_frame = np.asarray(frame, dtype=float)
    if teleops is None:
        teleops = []
        for mtm, psm in TELEOPS:
            if mtm in names and psm in names:
                pair = _dvrk.TeleopSpec()
                pair.mtm, pair.psm = names.index(mtm), names.index(psm)
                teleops.append(pair)
    camera = [names.index(a) for a in ("MTML", "MTMR", "ECM") if a in names]
    return _dvrk.System(specs, list(teleops), camera if len(camera) == 3 else [], head_sensor)

"""The leader in a scene file: arm model, placement, and imperfections of sensors and drives."""

from __future__ import annotations

import re
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import AfterValidator, BeforeValidator, Field, GetJsonSchemaHandler, WithJsonSchema, model_validator
from pydantic_core import CoreSchema

from palpate import _core
from palpate.arm import NAMES
from palpate.base.values import NotNegative, Number, Pose, Positive, Section
from palpate.scene.haply import HaplySection
from palpate.scene.jaws import GripperSection

_C = _core.SimulationOptions()


def _arm(name: str) -> str:
    if name in NAMES or name.endswith((".yaml", ".yml")):
        return name
    raise ValueError(f"there is no arm {name!r} | use {', '.join(NAMES)}; or the path of a model file, my_arm.yaml")


#: Name of an arm shipped with Palpate, or the path of a model file relative to the scene file (docs/arms.md).
ArmName = Annotated[
    str,
    AfterValidator(_arm),
    WithJsonSchema({"anyOf": [{"enum": list(NAMES)}, {"type": "string", "pattern": r"\.ya?ml$"}]}),
]
#: Drivers that ship with Palpate; text after a colon is their argument. `loop`: a program that calls palpate.Haptics.
DRIVERS = ("loop", "simulated", "shared-memory", "mouse", "keyboard", "gamepad", "webxr", "haply", "force-dimension")
FORCELESS = ("mouse", "keyboard", "gamepad", "webxr")
"""Drivers of devices that cannot give a force."""
_CLASS = re.compile(r"(?:[A-Za-z_][\w.]*|.+\.py):[A-Za-z_][\w.]*")


def _driver(name: str) -> str:
    if name.partition(":")[0] in DRIVERS or name.partition(":")[0].endswith(".so") or _CLASS.fullmatch(name):
        return name
    raise ValueError(
        f"there is no driver {name!r} | write MODULE:CLASS or FILE.py:CLASS, the path of a shared object "
        f"(my_device.so), or one of {', '.join(DRIVERS)}"
    )


def _named(value: Any) -> Any:
    """``{haply: {id: 04C3}}`` as the name of a driver with its argument, ``haply:id=04C3``."""
    if not isinstance(value, dict):
        return value
    if list(value) != ["haply"]:
        raise ValueError(
            f"there are no options for {', '.join(map(str, value)) or 'no driver'} | write {{haply: {{id: 04C3}}}}"
        )
    return HaplySection.model_validate(value["haply"] or {}).to_text()


class _DriverSchema:
    """The JSON schema of a driver's name or options, which is made on demand: it takes 20 ms."""

    @staticmethod
    def __get_pydantic_json_schema__(_: CoreSchema, __: GetJsonSchemaHandler) -> dict[str, Any]:
        haply = {
            "type": "object",
            "properties": {"haply": HaplySection.model_json_schema()},
            "required": ["haply"],
            "additionalProperties": False,
        }
        return {"anyOf": [{"type": "string"}, haply]}


#: Driver of a device, as `palpate.devices.open_driver` reads it (docs/device.md); {haply: {...}} gives its options.
DriverName = Annotated[
    str,
    BeforeValidator(_named),
    AfterValidator(_driver),
    _DriverSchema(),
]
Joints = Annotated[tuple[Number, ...], Field(min_length=1, max_length=7)]


class LeaderSection(Section):
    """The operator's arm: a simulated da Vinci master (MTM), a simulated arm of yours, or a device with a driver."""

    model: ArmName = "mtm_right"
    """arm model: a name, or the path of a model file relative to the scene file; ${VARIABLE}s are replaced"""
    driver: DriverName | None = None
    """instead of the simulated arm: your own device, MODULE:CLASS, FILE.py:CLASS, a shared object (my_device.so), or
    a driver that ships with Palpate (docs/device.md), {haply: {id: 04C3}} with options (docs/haply.md); the keys below
    other than base and frame then have no effect"""
    pseudo_haptic: bool | None = None
    """true: the viewer draws the tool on the surface while the hand goes in, and the force as a halo; for devices
    without force; when left out, true for the drivers keyboard, mouse, gamepad and webxr"""
    base: Pose | None = None
    """X_WL: pose of the arm's base in `frame`; automatic when left out, for a device with the axes of W"""
    frame: str = "world"
    """frame of the scene's frames in which base is given; with a frame and without base, the base is that frame"""
    start: Joints | None = None
    """joint positions at the start; when left out, the handle takes the orientation of the tool [rad, m]"""
    gripper: GripperSection = GripperSection()
    """the gripper, which moves the jaws of the follower"""
    model_mass_scale: Positive = 1.0
    """masses in the controller's gravity model relative to the true masses [-]"""
    gravity_model: str | None = None
    """gravity model of the controller: a file of `palpate calibrate gravity`, relative to the scene file; the arm's
    masses and counterbalance when left out"""
    plant_gravity_model: str | None = None
    """true gravity model of the simulated arm, a file as for gravity_model; the arm's masses when left out"""
    quantised: bool = _C.leader.quantised
    """true: encoders and velocities have the errors set by the keys below; false: true positions and velocities"""
    encoder_scale: NotNegative = 1.0
    """encoder resolution relative to the hardware's; 0: ideal positions [-]"""
    encoder_step: Annotated[tuple[NotNegative, ...], Field(min_length=1, max_length=7)] | None = None
    """instead of encoder_scale: size of an encoder count of each motor; 0: ideal [rad, m]"""
    velocity: Literal["edges", "difference"] = "edges"
    """edges: from the time between encoder counts, like the hardware; difference: from positions one cycle apart"""
    velocity_cutoff: Annotated[NotNegative, Field(le=1e5)] = _C.leader.velocity_cutoff
    """cut-off of a first-order low-pass filter of the velocities; 0: no filter [Hz]"""
    drive_lag: Annotated[NotNegative, Field(le=1.0)] = _C.leader.drive_lag
    """time constant of the drives' current loops, which delay all torques [s]"""
    drive_limit_scale: Positive = 1.0
    """saturation torque of the drives relative to the limit in the controller [-]"""
    coulomb_scale: NotNegative = 1.0
    """Coulomb friction of the arm relative to the model file; the controller uses the value of the file [-]"""
    load_cell_noise: Annotated[NotNegative, Field(lt=10.0)] = _C.leader.cell_noise
    """noise of the force sensor in the handle, rms per axis [N]"""

    @model_validator(mode="after")
    def _check(self) -> LeaderSection:
        if not self.quantised and (self.velocity != "edges" or self.velocity_cutoff > 0.0):
            what = "quantised: false reads the true velocities, velocity and velocity_cutoff have no effect"
            raise ValueError(f"{what} | for ideal positions with an estimated velocity give encoder_scale: 0")
        return self

    @property
    def shows_force(self) -> bool:
        """True if the viewer shows the force in place of the device (`pseudo_haptic`)."""
        if self.pseudo_haptic is not None:
            return self.pseudo_haptic
        return self.driver is not None and self.driver.partition(":")[0] in FORCELESS

    def apply_imperfections(self, o: _core.LeaderOptions, rate: float) -> None:
        """Apply the imperfections of this section to the options from the arm's model file.

        Args:
            o: options of the arm, changed in place.
            rate: rate of the haptic cycle [Hz].

        Raises:
            ValueError: encoder_step does not have one number per joint; the message is "what | mend".
        """
        if self.encoder_step is not None and len(self.encoder_step) != len(o.encoder_step):
            what = f"encoder_step must have {len(o.encoder_step)} numbers, one per joint. Got: {len(self.encoder_step)}"
            raise ValueError(f"{what} | or give encoder_scale")
        step = o.encoder_step if self.encoder_step is None else np.array(self.encoder_step)
        o.encoder_step = self.encoder_scale * step
        o.velocity_window = 1.0 / rate if self.velocity == "difference" else 0.0
        o.velocity_cutoff, o.drive_lag, o.quantised = self.velocity_cutoff, self.drive_lag, self.quantised
        o.tau_max, o.coulomb = self.drive_limit_scale * o.tau_max, self.coulomb_scale * o.coulomb
        o.cell_noise = self.load_cell_noise

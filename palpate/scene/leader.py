"""The leader in a scene file: which arm, where, and what is imperfect about it."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import AfterValidator, Field, WithJsonSchema, model_validator

from palpate import _core
from palpate.arm import NAMES
from palpate.values import NotNegative, Number, Pose, Positive, Section

_C = _core.SimulationOptions()


def _arm(name: str) -> str:
    if name in NAMES or name.endswith((".yaml", ".yml")):
        return name
    raise ValueError(f"there is no arm {name!r} | arms: {', '.join(NAMES)}; or the path of a model file, my_arm.yaml")


#: An arm that comes with Palpate, or the path of a model file, relative to the scene file (docs/arms.md).
ArmName = Annotated[
    str,
    AfterValidator(_arm),
    WithJsonSchema({"anyOf": [{"enum": list(NAMES)}, {"type": "string", "pattern": r"\.ya?ml$"}]}),
]
Joints = Annotated[tuple[Number, ...], Field(min_length=1, max_length=7)]


class LeaderSection(Section):
    """The operator's arm, simulated: a da Vinci master (MTM), or one of yours."""

    model: ArmName = "mtm_right"
    """which arm: a name, or the path of a model file relative to the scene file; ${VARIABLE}s are replaced"""
    base: Pose | None = None
    """X_WL: the arm's base in the world; automatic when left out"""
    start: Joints | None = None
    """joint positions at the start [rad, m]; when left out the handle takes the tool's orientation"""
    model_mass_scale: Positive = 1.0
    """masses in the controller's gravity model over the arm's true ones [-]"""
    gravity_model: str | None = None
    """what the controller holds the arm with: MODEL.yaml of `palpate calibrate gravity`, relative to the scene file;
    the arm's own masses and counterbalance when left out"""
    plant_gravity_model: str | None = None
    """what the simulated arm has to be held with, as gravity_model; its own masses when left out"""
    quantised: bool = _C.leader.quantised
    """encoders and velocities as the keys below say, or the truth"""
    encoder_scale: NotNegative = 1.0
    """size of a count over the hardware's; 0: ideal positions [-]"""
    encoder_step: Annotated[tuple[NotNegative, ...], Field(min_length=1, max_length=7)] | None = None
    """instead: size of a count of each motor, 0: ideal [rad, m]"""
    velocity: Literal["edges", "difference"] = "edges"
    """edges: from the time between counts, as the hardware; difference: of positions one haptic cycle apart"""
    velocity_cutoff: Annotated[NotNegative, Field(le=1e5)] = _C.leader.velocity_cutoff
    """of a first-order low-pass of the velocities; 0: none [Hz]"""
    drive_lag: Annotated[NotNegative, Field(le=1.0)] = _C.leader.drive_lag
    """time constant of the drives' current loops, of all torque [s]"""
    drive_limit_scale: Positive = 1.0
    """where the drives saturate over what the controller believes [-]"""
    coulomb_scale: NotNegative = 1.0
    """dry friction of the arm over the model file's; the controller believes the file [-]"""
    load_cell_noise: Annotated[NotNegative, Field(lt=10.0)] = _C.leader.cell_noise
    """of the force sensor in the handle, rms per axis [N]"""

    @model_validator(mode="after")
    def _whole(self) -> LeaderSection:
        if not self.quantised and (self.velocity != "edges" or self.velocity_cutoff > 0.0):
            told = "quantised: false reads the true velocities, velocity and velocity_cutoff do nothing"
            raise ValueError(f"{told} | for ideal positions with an estimated velocity give encoder_scale: 0")
        return self

    def spoil(self, o: _core.LeaderOptions, rate: float) -> None:
        """Put what the scene says on top of what the arm's model file says.

        Args:
            o: options of the arm, changed.
            rate: of the haptic cycle [Hz].

        Raises:
            ValueError: encoder_step has not one number per joint; "what | mend".
        """
        if self.encoder_step is not None and len(self.encoder_step) != len(o.encoder_step):
            told = f"encoder_step must have {len(o.encoder_step)} numbers, one per joint. Got: {len(self.encoder_step)}"
            raise ValueError(f"{told} | or give encoder_scale")
        step = o.encoder_step if self.encoder_step is None else np.array(self.encoder_step)
        o.encoder_step = self.encoder_scale * step
        o.velocity_window = 1.0 / rate if self.velocity == "difference" else 0.0
        o.velocity_cutoff, o.drive_lag, o.quantised = self.velocity_cutoff, self.drive_lag, self.quantised
        o.tau_max, o.coulomb = self.drive_limit_scale * o.tau_max, self.coulomb_scale * o.coulomb
        o.cell_noise = self.load_cell_noise

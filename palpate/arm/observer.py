"""Options of the momentum observer in the cycle (`_core.Estimate`), from the identified dynamics of an arm."""

from __future__ import annotations

import numpy as np

from palpate import _core
from palpate.arm.dynamics import Dynamics
from palpate.base.arrays import Array
from palpate.base.errors import RecordingError


def drive_inertia(d: Dynamics) -> Array:
    """Inertia (n, n) of the rotors, reflected to the joints [kg m^2, kg]."""
    to_drives = np.linalg.pinv(d.train.coupling)  # (m, n)
    return np.asarray(to_drives.T @ np.diag(_per_drive(d, "rotor")) @ to_drives)


def estimate_options(d: Dynamics, base: _core.EstimateOptions | None = None) -> _core.EstimateOptions:
    """Options of the estimate: links, rotors, friction, offsets and springs at the joints; the others come from `base`.

    The friction of coupled motors is that of each joint moving alone. Terms of a jaw are left out.

    Raises:
        RecordingError: the arm has springs that are not linear in one joint (an MTM), which the cycle cannot evaluate.
    """
    options = base or _core.EstimateOptions()
    n, theta = d.arm.n, _theta(d)
    to_drives = np.linalg.pinv(d.train.coupling)
    coulomb = np.abs(to_drives).T @ _per_drive(d, "coulomb")
    viscous = (to_drives**2).T @ _per_drive(d, "viscous")
    spring = np.zeros(n)
    for name, value in theta.items():
        kind, _, joint = name.rpartition("_")
        if kind == "joint_coulomb":
            coulomb[int(joint) - 1] += value
        elif kind == "joint_viscous":
            viscous[int(joint) - 1] += value
        elif name == "roll_spring":
            spring[3] += value
        elif kind == "spring":
            spring[int(joint) - 1] += value
        elif kind not in ("coulomb", "viscous", "offset", "rotor", "jaw"):
            raise RecordingError(
                f"the dynamics model of {d.arm.name!r} cannot be used for a follower",
                why=f"the observer cannot evaluate its term {name!r}",
                mend="estimate the force of a PSM, or of an arm of your own",
            )  # fmt: skip
    options.links, options.rotor_inertia = d.pi, drive_inertia(d).diagonal()
    options.coulomb, options.viscous, options.spring = coulomb, viscous, spring
    options.offset = to_drives.T @ _per_drive(d, "offset")
    return options


def _theta(d: Dynamics) -> dict[str, float]:
    return dict(zip((t.name for t in d.train.terms), d.theta, strict=True))


def _per_drive(d: Dynamics, kind: str) -> Array:
    theta = _theta(d)
    return np.array([theta[f"{kind}_{j + 1}"] for j in range(d.train.coupling.shape[1])])

"""Elastic and viscous values of one soft tissue, checked."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.base.arrays.checks import not_negative, positive
from palpate.world.tissue.bounds import HIGHEST_POISSON, MOST_TERMS
from palpate.world.tissue.viscosity import Prony


@dataclass(frozen=True)
class TissueMaterial:
    """A soft tissue: a Neo-Hookean solid with Yeoh's stiffening term and a Prony series.

    `palpate._tissue.TissueBody` states the strain energy.
    `young` and `shear` are the moduli at small strain and at rest (after infinite time). A fast deformation meets the
    shear modulus `shear * (1 + sum g_i)`.

    Raises:
        ValueError: a value that no tissue has; the message says which and why.
    """

    young: float  #: Young's modulus [Pa]
    poisson: float = 0.45  #: Poisson's ratio [-]
    density: float = 1050.0  #: [kg/m^3]
    yeoh: float = 0.0  #: coefficient of the quadratic term [-]; stiffening with strain
    prony: Prony = ()  #: terms (g_i [-], tau_i [s]) of the relaxing shear modulus, over the modulus at rest
    source: str = ""  #: where the values come from

    def __post_init__(self) -> None:
        positive("young", self.young, "Pa")
        positive("density", self.density, "kg/m^3")
        not_negative("yeoh", self.yeoh)
        if not (0.0 <= self.poisson <= HIGHEST_POISSON):
            why = "an incompressible body has no finite bulk modulus" if self.poisson >= 0.5 else "outside the range"
            raise ValueError(f"poisson must lie from 0 to {HIGHEST_POISSON}, got {self.poisson!r}: {why}; use 0.45")
        _check_prony(self.prony)

    @classmethod
    def from_shear(cls, shear: float, poisson: float = 0.45, **values: object) -> TissueMaterial:
        """The material of a shear modulus [Pa]: young = 2 shear (1 + poisson). `values` are the other fields."""
        return cls(2.0 * positive("shear", shear, "Pa") * (1.0 + poisson), poisson, **values)  # type: ignore[arg-type]

    @property
    def shear(self) -> float:
        """Shear modulus at rest [Pa]."""
        return self.young / (2.0 * (1.0 + self.poisson))

    @property
    def bulk(self) -> float:
        """Bulk modulus [Pa]."""
        return self.young / (3.0 * (1.0 - 2.0 * self.poisson))

    @property
    def instantaneous(self) -> float:
        """Young's modulus that a sudden deformation meets [Pa], with the bulk modulus unchanged."""
        shear = self.shear * (1.0 + sum(g for g, _ in self.prony))
        return 9.0 * self.bulk * shear / (3.0 * self.bulk + shear)

    @property
    def wave_speed(self) -> float:
        """Speed of pressure waves just after a sudden deformation [m/s]: it limits the time step."""
        shear = self.shear * (1.0 + sum(g for g, _ in self.prony))
        return float(np.sqrt((self.bulk + 4.0 / 3.0 * shear) / self.density))


LARGEST_SHARE = 100.0
"""Largest sum of the terms' shares g [-]: the time step must resolve the modulus at once."""

SHORTEST_TAU, LONGEST_TAU = 1e-5, 1e3
"""Time constants of the terms that a body accepts [s]. A shorter one is a damper that no step of a loop resolves; with
a longer one single precision would lose the steps of the relaxation."""


def _check_prony(prony: Prony) -> None:
    for i, (g, tau) in enumerate(prony):
        not_negative(f"prony[{i}]: the relaxing modulus", g)
        positive(f"prony[{i}]: the time constant", tau, "s")
        if not SHORTEST_TAU <= tau <= LONGEST_TAU:
            raise ValueError(
                f"prony[{i}]: the time constant must lie from {SHORTEST_TAU:g} to {LONGEST_TAU:g} s, got {tau:g}: "
                "leave out a shorter term, and add a longer one to young"
            )
    if len(prony) > MOST_TERMS:
        raise ValueError(f"prony has {len(prony)} terms; a body has at most {MOST_TERMS}")
    total = sum(g for g, _ in prony)
    if total > LARGEST_SHARE:
        raise ValueError(f"the relaxing moduli of prony sum to {total:g}, more than {LARGEST_SHARE:g}: raise young")

"""Closed form of the force of soft tissue, beside which a report draws the force of a run."""

from __future__ import annotations

from dataclasses import dataclass

from palpate.report.run import Run


@dataclass(frozen=True)
class SoftLaw:
    """Tissue and sphere of a run."""

    radius: float  #: of the sphere on the tool's tip [m]
    rest: float  #: Young's modulus at rest [Pa]
    fast: float  #: Young's modulus before relaxation [Pa]
    poisson: float  #: Poisson's ratio [-]


def soft_law(run: Run) -> SoftLaw | None:
    """The law of the first soft object in the run's scene; None if the scene has none."""
    from palpate.scene.soft import TissueSection

    sections = (obj.get("tissue") for obj in run.setting("objects") or () if isinstance(obj, dict))
    section = next((s for s in sections if s), None)
    if section is None:
        return None
    material = TissueSection.model_validate(section).material
    radius = float(run.setting("contact", "radius") or 0.002)
    return SoftLaw(radius, material.young, material.instantaneous, material.poisson)

"""Materials of tissues and phantoms by name, each with the source of its modulus.

Published moduli differ by factors between specimens, ages and rates: a preset is a start, and
``palpate identify tissue`` fits your own. Relaxation and stiffening are assumptions: organs relax by a power law of
time (Capilnasiu and others 2020, bovine liver; Mishra and Cleveland 2024, porcine liver and kidney), which the three
terms imitate from 10 ms to 10 s; measured moduli of elastography count as moduli at rest.
"""

from __future__ import annotations

from palpate.tissue.material import TissueMaterial
from palpate.tissue.viscosity import Prony

_PMC = "PMC6925591"
_PARENCHYMA = ((0.35, 0.02), (0.25, 0.3), (0.2, 4.0))
_FAT = ((0.25, 0.02), (0.15, 0.3), (0.1, 4.0))
_PHANTOM = ((0.03, 0.05),)


def _organ(shear: float, density: float, prony: Prony, yeoh: float, source: str) -> TissueMaterial:
    return TissueMaterial.from_shear(shear, 0.45, density=density, prony=prony, yeoh=yeoh, source=source)


def _phantom(young: float, density: float, source: str) -> TissueMaterial:
    return TissueMaterial(young, 0.45, density, prony=_PHANTOM, source=source)


_SILICONE = "silicone phantoms: 5 to 112 kPa; a soft platinum-cured rubber relaxes little"
_AGAR = "agar phantoms: 5 to 81 kPa, by concentration"

PRESETS: dict[str, TissueMaterial] = {
    "liver": _organ(1.8e3, 1060.0, _PARENCHYMA, 0.5, f"shear modulus 1.8 +- .4 kPa, healthy: {_PMC}"),
    "liver_diseased": _organ(19.8e3, 1060.0, _PARENCHYMA, 0.5, f"shear modulus 19.8 kPa: {_PMC}"),
    "carcinoma": _organ(23.4e3, 1060.0, _PARENCHYMA, 0.5, f"shear modulus 23.4 kPa, in the liver: {_PMC}"),
    "gallbladder": _organ(85.0e3, 1050.0, _FAT, 0.5, f"shear modulus 85 kPa: {_PMC}"),
    "kidney": _organ(
        1.81e3,
        1050.0,
        _PARENCHYMA,
        0.5,
        "shear modulus 1.81 +- .17 kPa, swine cortex: Amador and others, shearwave dispersion; a human cortex: "
        "Young's modulus 5.0 +- 2.9 kPa (doi 10.2214/AJR.10.5449)",
    ),
    "fat": _organ(
        752.0, 920.0, _FAT, 1.0, "shear modulus 752 Pa at 50 Hz, gluteal, by MR elastography under compression (2023)"
    ),
    "silicone_5kPa": _phantom(5e3, 1070.0, _SILICONE),
    "silicone_20kPa": _phantom(20e3, 1070.0, _SILICONE),
    "silicone_60kPa": _phantom(60e3, 1070.0, _SILICONE),
    "silicone_110kPa": _phantom(110e3, 1070.0, _SILICONE),
    "agar_10kPa": _phantom(10e3, 1010.0, _AGAR),
    "agar_40kPa": _phantom(40e3, 1010.0, _AGAR),
}

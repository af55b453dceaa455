"""Materials of tissues and phantoms by name, each with the measurement that its modulus comes from.

Published moduli differ by factors between specimens, ages and rates: a preset is a start, and
``palpate identify tissue`` fits your own. Relaxation and stiffening are assumptions: organs relax by a power law of
time (Capilnasiu and others 2020, bovine liver; Mishra and Cleveland 2024, porcine liver and kidney), which the three
terms imitate from 10 ms to 10 s. The modulus at rest is the one with which the material's modulus at the frequency of
the measurement is the measured one.
"""

from __future__ import annotations

from dataclasses import dataclass

from palpate.world.tissue.material import TissueMaterial
from palpate.world.tissue.viscosity import Prony, complex_modulus


@dataclass(frozen=True)
class Measurement:
    """A published shear modulus."""

    shear: float  #: [Pa]
    frequency: float  #: [Hz]; 0: quasi-static
    strain: str  #: at what strain
    where: str  #: specimen, method and publication

    def __str__(self) -> str:
        """The measurement in a line."""
        rate = f"at {self.frequency:g} Hz" if self.frequency else "quasi-static"
        return f"shear modulus {self.shear:g} Pa, {rate}, {self.strain}: {self.where}"

    def at_rest(self, prony: Prony) -> float:
        """Shear modulus at rest [Pa] of a material that relaxes by a Prony series and shows this modulus."""
        return self.shear / abs(complex_modulus(prony, self.frequency))


_PARENCHYMA = ((0.35, 0.02), (0.25, 0.3), (0.2, 4.0))
_FAT = ((0.25, 0.02), (0.15, 0.3), (0.1, 4.0))
_PHANTOM = ((0.03, 0.05),)
_POISSON = 0.45


def _review(shear: float, what: str) -> Measurement:
    where = (
        "literature values of a study of ultrasound in the liver (Phys Med Biol 2019, 64 225001, PMC6925591, table 1)"
    )
    return Measurement(shear, 0.0, "small strain", f"{what}; {where}")


def _nominal(young: float, kind: str) -> Measurement:
    return Measurement(young / (2.0 * (1.0 + _POISSON)), 0.0, "small strain", f"nominal; {kind}")


_SILICONE = "silicone phantoms have 5 to 112 kPa, and a soft platinum-cured rubber relaxes little"
_AGAR = "agar phantoms have 5 to 81 kPa, by concentration"

MEASUREMENTS: dict[str, Measurement] = {
    "liver": _review(1.8e3, "human liver, 1.8 +- .4 kPa"),
    "liver_diseased": _review(19.8e3, "human liver, diseased"),
    "carcinoma": _review(23.4e3, "hepatocellular carcinoma"),
    "gallbladder": _review(85.0e3, "gallbladder wall, 85 +- 8.2 kPa"),
    "kidney": Measurement(
        1.81e3,
        160.0,
        "waves of micrometres",
        "cortex of excised swine kidneys, 1.81 +- .17 kPa: elasticity of a Voigt model over 50 to 500 Hz, of which 160 "
        "Hz is the middle, by shear waves (Amador and others 2011, IEEE Trans. Ultrason. 58 2608)",
    ),
    "fat": Measurement(
        752.0,
        50.0,
        "waves of micrometres, without compression",
        "gluteal fat of ten women, |G*| by MR elastography (Strain-dependent shear properties of human adipose tissue "
        "in vivo, J. Mech. Behav. Biomed. Mater. 2023)",
    ),
    "silicone_5kPa": _nominal(5e3, _SILICONE),
    "silicone_20kPa": _nominal(20e3, _SILICONE),
    "silicone_60kPa": _nominal(60e3, _SILICONE),
    "silicone_110kPa": _nominal(110e3, _SILICONE),
    "agar_10kPa": _nominal(10e3, _AGAR),
    "agar_40kPa": _nominal(40e3, _AGAR),
}


def _material(name: str, density: float, prony: Prony, yeoh: float) -> TissueMaterial:
    measured = MEASUREMENTS[name]
    shear = measured.at_rest(prony)
    return TissueMaterial.from_shear(shear, _POISSON, density=density, prony=prony, yeoh=yeoh, source=str(measured))


PRESETS: dict[str, TissueMaterial] = {
    "liver": _material("liver", 1060.0, _PARENCHYMA, 0.5),
    "liver_diseased": _material("liver_diseased", 1060.0, _PARENCHYMA, 0.5),
    "carcinoma": _material("carcinoma", 1060.0, _PARENCHYMA, 0.5),
    "gallbladder": _material("gallbladder", 1050.0, _FAT, 0.5),
    "kidney": _material("kidney", 1050.0, _PARENCHYMA, 0.5),
    "fat": _material("fat", 920.0, _FAT, 1.0),
    "silicone_5kPa": _material("silicone_5kPa", 1070.0, _PHANTOM, 0.0),
    "silicone_20kPa": _material("silicone_20kPa", 1070.0, _PHANTOM, 0.0),
    "silicone_60kPa": _material("silicone_60kPa", 1070.0, _PHANTOM, 0.0),
    "silicone_110kPa": _material("silicone_110kPa", 1070.0, _PHANTOM, 0.0),
    "agar_10kPa": _material("agar_10kPa", 1010.0, _PHANTOM, 0.0),
    "agar_40kPa": _material("agar_40kPa", 1010.0, _PHANTOM, 0.0),
}

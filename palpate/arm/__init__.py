"""Arms: kinematics, dynamics, hands on them, and what is identified from recordings of real ones."""

from palpate.arm.arm import INSTRUMENTS, NAMES, SIDES, Arm, models_folder

__all__ = ["INSTRUMENTS", "NAMES", "SIDES", "Arm", "models_folder"]

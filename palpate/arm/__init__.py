"""Arms: kinematics, dynamics and appearance of a leader or follower (`palpate.Arm`)."""

from palpate.arm.arm import INSTRUMENTS, NAMES, SIDES, Arm, models_folder

__all__ = ["INSTRUMENTS", "NAMES", "SIDES", "Arm", "models_folder"]

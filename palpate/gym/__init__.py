"""Environments of Gymnasium over any scene: an instrument that is moved by actions, and feels.

env = gymnasium.make("palpate.gym:Palpate-v0", scene="palpation")
many = palpate.gym.PalpateVectorEnv(64, scene="palpation")

The instrument is a follower of Palpate under its whole haptic cycle: guidance, contact, force law, caps and watchdog
act as on a person's device.
"""

from palpate.base.errors import MissingExtraError

try:
    import gymnasium
except ImportError:
    raise MissingExtraError("gymnasium", "learning") from None

from palpate.gym.drive import Drive, drive
from palpate.gym.env import PalpateEnv
from palpate.gym.mixing import Hand
from palpate.gym.policy import OnnxPolicy
from palpate.gym.shared import share
from palpate.gym.tasks import Find, Press, Task
from palpate.gym.vector import PalpateVectorEnv
from palpate.gym.world import Motion

__all__ = [
    "Drive", "Find", "Hand", "Motion", "OnnxPolicy", "PalpateEnv", "PalpateVectorEnv", "Press", "Task", "drive",
    "share",
]  # fmt: skip

if "Palpate-v0" not in gymnasium.registry:
    gymnasium.register(
        "Palpate-v0",
        entry_point="palpate.gym.env:PalpateEnv",
        vector_entry_point="palpate.gym.vector:PalpateVectorEnv",
    )

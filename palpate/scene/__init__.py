"""Scene files: all inputs of a run, read from YAML, with the fixtures and contact methods that they name."""

from palpate.base.values import Pose
from palpate.scene.leader import LeaderSection
from palpate.scene.mapping import MappingSection
from palpate.scene.model import (
    ArmsSection,
    ContactSection,
    FollowerSection,
    ObjectSection,
    RatesSection,
    RecordSection,
    TorqueSection,
)
from palpate.scene.operator import OperatorSection, PalpateSection, WayPoint
from palpate.scene.scene import Scene
from palpate.scene.stability import StabilitySection

__all__ = [
    "ArmsSection",
    "ContactSection",
    "FollowerSection",
    "LeaderSection",
    "MappingSection",
    "ObjectSection",
    "OperatorSection",
    "PalpateSection",
    "Pose",
    "RatesSection",
    "RecordSection",
    "Scene",
    "StabilitySection",
    "TorqueSection",
    "WayPoint",
]

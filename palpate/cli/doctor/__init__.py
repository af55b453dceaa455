"""What a machine has and lacks for Palpate, and how to fix what is missing: `palpate doctor`."""

from palpate.cli.doctor.examination import TOPICS, examine
from palpate.cli.doctor.finding import Finding

__all__ = ["TOPICS", "Finding", "examine"]

"""Generated shapes: nothing is downloaded, and every machine generates the same arrays."""

from palpate.world.shapes.duodenum import duodenum
from palpate.world.shapes.organ import gallbladder, organ

__all__ = ["duodenum", "gallbladder", "organ"]

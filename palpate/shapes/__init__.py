"""Generated shapes: nothing is downloaded, and every machine generates the same arrays."""

from palpate.shapes.duodenum import duodenum
from palpate.shapes.organ import gallbladder, organ

__all__ = ["duodenum", "gallbladder", "organ"]

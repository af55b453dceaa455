"""From views of a depth camera to a surface that can be touched: outliers, alignment, reconstruction, holes."""

from palpate.world.scan.scan import Scan, scan

__all__ = ["Scan", "scan"]

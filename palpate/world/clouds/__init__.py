"""Point clouds: points in space with optional normals and colours, and the files that hold them."""

from palpate.world.clouds.cloud import MAX_POINTS, PointCloud

__all__ = ["MAX_POINTS", "PointCloud"]

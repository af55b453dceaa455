"""Triangle meshes: files, checks, repairs (`palpate.Mesh`)."""

from palpate.world.mesh.mesh import Mesh, Unit, quiet

__all__ = ["Mesh", "Unit", "quiet"]

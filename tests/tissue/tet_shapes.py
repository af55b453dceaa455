"""Small meshes of tetrahedra for tests."""

import numpy as np

# Kuhn's subdivision of a cube into six tetrahedra along the diagonal from corner 0 to corner 7 (corner = x + 2y + 4z).
_KUHN = np.array([[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]])


def block(cells=(2, 2, 2), size=(0.02, 0.02, 0.02)):
    """Nodes and tetrahedra of a block of cubes from the origin."""
    nx, ny, nz = (n + 1 for n in cells)
    z, y, x = np.meshgrid(*(np.linspace(0, s, n) for s, n in zip(size[::-1], (nz, ny, nx), strict=True)), indexing="ij")
    nodes = np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1)
    k, j, i = np.meshgrid(np.arange(nz - 1), np.arange(ny - 1), np.arange(nx - 1), indexing="ij")
    first = ((k * ny + j) * nx + i).ravel()
    corner = np.array([a + nx * (b + ny * c) for c in (0, 1) for b in (0, 1) for a in (0, 1)])
    return nodes, (first[:, None, None] + corner[_KUHN]).reshape(-1, 4).astype(np.int32)

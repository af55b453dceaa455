"""Program that fills a surface with tetrahedra: reads ``surface.npz`` of its working folder, writes ``volume.npz``.

fTetWild runs in a process of its own, because it cannot be interrupted and leaves a file in the working folder.
"""

import numpy as np
from pytetwild.pytetwild import tetrahedralize


def main() -> None:
    """Fill ``vertices`` (n, 3) and ``triangles`` (m, 3), of size one, with edges of ``edge`` within ``envelope``."""
    with np.load("surface.npz") as surface:
        nodes, tets = tetrahedralize(
            surface["vertices"],
            surface["triangles"],
            edge_length_fac=float(surface["edge"]),
            epsilon=float(surface["envelope"]),
            num_threads=1,  # the result is then the same on every run
            quiet=True,
        )
    np.savez("volume.npz", nodes=nodes, tets=tets)


if __name__ == "__main__":
    main()

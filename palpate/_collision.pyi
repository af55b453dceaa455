# Generated from the bindings by `make stubs`; do not edit. An array type states its shape; ":" is any length.
"""
The paper's contact methods, on collisions of triangles; the import adds them to those of the core.
"""

from typing import Annotated, Any

import numpy
from numpy.typing import NDArray

import palpate._core


def trace_algorithm1(
    snapshot: palpate._core.Snapshot,
    p_WT: Annotated[NDArray[numpy.float64], "(3,)"],
    v_WT: Annotated[NDArray[numpy.float64], "(3,)"],
    radius: float,
    n_last: Annotated[NDArray[numpy.float64], "(3,)"],
) -> dict[str, Any]:
    """
    Values of every line of Algorithm 1 for one tool position p_WT (3,) and velocity v_WT (3,); in W, SI units.
    """

def grow_plane(
    points: Annotated[NDArray[numpy.float64], "(:, 3)"],
    n_last: Annotated[NDArray[numpy.float64], "(3,)"],
    baseline: float,
) -> Annotated[NDArray[numpy.float64], "(3,)"]:
    """
    Unit normal (3,) of the plane that the method `paper-plane` fits to points (n, 3) [m]; zero if it rejects them.
    """

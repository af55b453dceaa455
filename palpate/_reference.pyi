# Generated from the bindings by `make stubs`; do not edit. An array type states its shape; ":" is any length.
"""
Pinocchio's dynamics of an arm, with which tests and benchmarks compare ours.
"""

from typing import Annotated, Any

import numpy
import numpy.typing
from numpy.typing import NDArray


class AllTerms:
    """
    Pinocchio's dynamics of a URDF; tests and benchmarks compare Arm with it.
    """

    def __init__(self, xml: str, base_frame: str, tip_frame: str) -> None: ...

    def compute(
        self,
        q: numpy.typing.ArrayLike,
        v: numpy.typing.ArrayLike,
    ) -> tuple[
        Annotated[NDArray[numpy.float64], "(:, :)"],
        Annotated[NDArray[numpy.float64], "(:,)"],
        Annotated[NDArray[numpy.float64], "(:,)"],
        Annotated[NDArray[numpy.float64], "(:, :)"],
    ]:
        """
        computeAllTerms: (M (n,n), C v + G (n,), G (n,), J (6,n) at the tip in base axes).
        """

class BareDynamics:
    """
    Times Pinocchio's computeAllTerms of both arms, as a baseline for the compute time of a cycle.
    """

    def __init__(self, leader: AllTerms, follower: AllTerms) -> None: ...

    def run(
        self,
        q_leader: Annotated[NDArray[numpy.float64], "(:, :)"],
        v_leader: Annotated[NDArray[numpy.float64], "(:, :)"],
        q_follower: Annotated[NDArray[numpy.float64], "(:, :)"],
    ) -> None:
        """
        Times k ticks: q_leader (n, k), v_leader (n, k) and q_follower (m, k) [rad, m; rad/s, m/s].
        """

    def timing(self) -> dict[str, Any]:
        """Compute times p50, p99, p999 and max [us]."""

"""Hand-eye calibration of a camera on or beside an arm from views of a board: `handeye`."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array
from palpate.base.arrays.rigid import displaced, inverse, rigid
from palpate.base.errors import RegistrationError
from palpate.world.registration import checks, order, predict
from palpate.world.registration.closed_chain import Chain, missing_axis
from palpate.world.registration.components import Components
from palpate.world.registration.deletion import Linearised, deletions
from palpate.world.registration.quaternion_order import reordered

_USUAL = (0.3e-3, np.radians(0.2))  # errors of a board seen by a camera, used as first weights [m, rad]
_ROUNDS = 2  # linearisations with estimated errors
LEAST = 4  # fewest views: three leave six degrees of freedom for three unknown errors
FEW = 48  # degrees of freedom below which the unknown errors make the covariance clearly larger: under ten views
_OTHER_SIZE = 0.003  # probability below which the board has another size than stated
_MISFIT = 40.0  # median residual, in usual errors of a view, above which the poses do not belong together

Mount = Literal["arm", "beside"]


@dataclass(frozen=True)
class HandEye:
    """Result of `handeye`."""

    X: Array  #: (4, 4) the camera in the tool frame E (on the arm), or in the base B (beside it)
    board: Array  #: (4, 4) the board in the base B (camera on the arm), or in the tool frame E
    covariance: Array  #: (6, 6) of the displacement of X (NOTATION.md)
    board_covariance: Array  #: (6, 6) of the displacement of `board`
    fre: float  #: rms position residual of the board in the camera's frame [m]
    rotation_fre: float  #: rms rotation residual [rad]
    fle: float  #: rms position error of one view, estimated from the residuals [m]
    rotation_fle: float  #: rms rotation error of one view [rad]
    tre: Array  #: (K,) predicted rms error at each target [m]
    targets: tuple[predict.Target, ...]
    residuals: Array  #: (N,) position residual of each view [m]
    freedom: int  #: measured numbers less the twelve unknowns; few make the covariance large
    outliers: tuple[int, ...]  #: views excluded as wrong
    size: float  #: distances that the camera reports over those that the arm moved; 1 for a board as large as stated
    size_deviation: float  #: standard deviation of `size`
    warnings: tuple[str, ...]


def handeye(
    arm: npt.ArrayLike, camera: npt.ArrayLike, mount: Mount = "arm", targets: npt.ArrayLike | None = None
) -> HandEye:
    """The pose of a camera on or beside an arm, from poses of the arm and views of a board.

    With the camera on the arm, ``X_EB X_BK = X_EC X_CK``; eliminating the unknown X_BK gives the equation AX = XB. With
    the camera beside the arm and the board on the tool, ``X_BE X_EK = X_BC X_CK``. Both are A X = Z C with the camera's
    pose Z, solved in closed form and refined by least squares on the errors of the views.

    Args:
        arm: X_BE (N, 4, 4), tool frame E in the base B.
        camera: X_CK (N, 4, 4), board K in the camera C, of the same instants.
        mount: "arm" or "beside".
        targets: points (K, 3) in the camera's frame where the error is predicted [m].

    Raises:
        RegistrationError: fewer than four poses, rotations about one axis only, matrices that are not rigid, or poses
            that do not belong together.
    """
    X_BE, X_CK = (checks.poses(name, X, LEAST) for name, X in (("arm", arm), ("camera", camera)))
    if len(X_BE) != len(X_CK):
        raise RegistrationError(f"{len(X_BE)} poses of the arm and {len(X_CK)} views", mend="give one view per pose")
    if mount not in ("arm", "beside"):
        raise RegistrationError(f"there is no mount {mount!r}", mend="use 'arm' or 'beside'")
    goals = np.zeros((0, 3)) if targets is None else checks.cloud("targets", targets, least=1)
    _check_axes(X_BE)
    chain = _chain(X_BE, X_CK, mount)
    _check_together(X_BE, X_CK, mount)

    def linearised(rows: list[int]) -> Linearised:
        return _components(chain[rows], *chain[rows].closed_form()).linearised()

    wrong = deletions(len(X_BE), LEAST, linearised, known=False)
    kept = [k for k in range(len(X_BE)) if k not in wrong]
    _check_axes(X_BE[kept])
    return _solved(chain, kept, wrong, goals)


def _chain(X_BE: Array, X_CK: Array, mount: Mount) -> Chain:
    return Chain(inverse(X_BE) if mount == "arm" else X_BE, X_CK, np.repeat(1.0 / np.array(_USUAL), 3),
                 on_arm=mount == "arm")  # fmt: skip


def _components(chain: Chain, X: Array, Z: Array) -> Components:
    """The fit about X and Z. Rotation errors of the arm turn the board about the tool, those of a view about itself."""
    r = chain.residuals(X, Z) * chain.weights
    return Components(r, chain.derivatives(X, Z), chain.weights[:, None] * chain.turned_tool(Z) / chain.weights[3:])


def _solved(chain: Chain, kept: list[int], wrong: list[int], goals: Array) -> HandEye:
    X, Z, _ = chain[kept].refined()
    for _ in range(_ROUNDS):
        fits = _components(chain[kept], X, Z).fits()
        X, Z = displaced(X, fits.solution[:6]), displaced(Z, fits.solution[6:])
    C_X, C_Z = fits.covariance(slice(0, 6)), fits.covariance(slice(6, 12))
    sigma = np.array(fits.sigma()) * _USUAL
    found = tuple(predict.target(Z, C_Z, p) for p in goals)
    lengths = np.linalg.norm(chain.residuals(X, Z).reshape(-1, 2, 3), axis=2)
    rms = np.sqrt(np.square(lengths[kept]).mean(axis=0))
    size, deviation, other = _size(chain[kept], X, Z)
    if wrong and not other:  # a wrong size also looks like wrong views
        size, deviation, other = _size(chain, X, Z)
    return HandEye(
        X=Z, board=X, covariance=C_Z, board_covariance=C_X, freedom=fits.freedom,
        fre=float(rms[0]), rotation_fre=float(rms[1]),
        fle=float(np.sqrt(3.0) * sigma[0]), rotation_fle=float(np.sqrt(3.0) * sigma[1]),
        tre=np.array([one.tre for one in found]), targets=found, residuals=lengths[:, 0], outliers=tuple(wrong),
        size=size, size_deviation=deviation, warnings=(
            *_warnings(len(kept), fits.freedom, size, deviation, other),
            *order.remarks(chain.residuals(X, Z)[kept] * chain.weights / np.repeat(fits.sigma(), 3)),
        ),
    )  # fmt: skip


def _size(chain: Chain, X: Array, Z: Array) -> tuple[float, float, bool]:
    """Size of the camera's distances over the arm's, its standard deviation, and whether it is surely not one.

    It is a thirteenth parameter: the arm measures metres, so a board printed too large shows itself.
    """
    from scipy.special import chdtri

    rigidly = _components(chain, X, Z)
    away = np.zeros((*rigidly.r.shape, 1))
    away[:, :3, 0] = chain.weights[:3] * (inverse(Z) @ chain.A @ X)[:, :3, 3]
    fits = replace(rigidly, J=np.concatenate([rigidly.J, away], axis=2)).fits()
    change, last = float(fits.solution[-1]), slice(12, 13)
    limit = float(fits.covariance(last, 1.0 - _OTHER_SIZE)[0, 0]) * chdtri(1, _OTHER_SIZE)
    return 1.0 + change, float(np.sqrt(fits.covariance(last)[0, 0])), change**2 > limit and abs(change) > 1e-6


def _warnings(views: int, freedom: int, size: float, deviation: float, other: bool) -> tuple[str, ...]:
    found = []
    if freedom < FEW:
        found.append(
            f"{views} views hardly show their own errors: the predicted error includes that they are unknown; 10 views "
            "or more make it smaller"
        )
    if other:
        found.append(
            f"the camera's distances are {size:.4f} +- {deviation:.4f} times those of the arm: the board has another "
            "size than stated, or the camera's focal length is wrong, which the predicted error does not include"
        )
    return tuple(found)


def _check_axes(X_BE: Array) -> None:
    lacking = missing_axis(X_BE)
    if lacking is not None:
        about, missing, angle = lacking
        words = [", ".join(f"{x:.2f}" for x in axis) for axis in (about, missing)]
        raise RegistrationError(
            f"the {len(X_BE)} poses turn about ({words[0]}) of the tool frame alone: {np.degrees(angle):.1f} deg rms "
            "about any other axis",
            why="parallel rotation axes do not determine the camera's position along them",
            mend=f"add two poses turned by 30 deg or more about ({words[1]}) of the tool frame, one each way",
        )


def _check_together(X_BE: Array, X_CK: Array, mount: Mount) -> None:
    """Check that constant X and Z explain most views, and name the misreading that would.

    Raises:
        RegistrationError: they explain less than half of the views.
    """
    misfit = _misfit(X_BE, X_CK, mount)
    if misfit < _MISFIT:
        return
    kinds: dict[str, Callable[[Array], Array]] = {
        "": lambda X: X,
        "have quaternions in the other order": reordered,
        "are inverted": inverse,
        "are in millimetres, a ratio of 1000 to metres": _from_mm,
    }
    causes: dict[int, list[str]] = {}  # by number of misreadings
    for (arm, read_arm), (board, read_board) in itertools.product(kinds.items(), kinds.items()):
        if _misfit(read_arm(X_BE), read_board(X_CK), mount) < min(_MISFIT, 0.2 * misfit):
            read = (("of the arm (tool in base)", arm), ("of the board (board in camera)", board))
            faults = [f"the poses {name} {fault}" for name, fault in read if fault]
            causes.setdefault(len(faults), []).append(" and ".join(faults))
    other: Mount = "beside" if mount == "arm" else "arm"
    if causes and _misfit(X_BE, X_CK, other) < _MISFIT:
        causes.setdefault(1, []).append(
            f"the camera is {'on' if other == 'arm' else 'beside'} the arm (--mount {other})"
        )
    if causes:
        raise RegistrationError(
            ", or ".join(causes[min(causes)]),
            why="as given, no camera pose explains the views; read the other way, one does",
            mend="name the quaternion's columns after their values; give tool in base and board in camera",
        )
    raise RegistrationError(
        f"no camera pose explains the views: the median residual is {misfit:.0f} times that of a usual camera",
        why="the rows are not of the same instants, the mount is another, or the lengths are in another unit",
        mend="record both while the arm stands still, keep the order of the rows, and check --mount and the unit",
    )


def _misfit(X_BE: Array, X_CK: Array, mount: Mount) -> float:
    """Median residual of the closed form in usual errors of a view, without unit."""
    chain = _chain(X_BE, X_CK, mount)
    return float(np.median(np.linalg.norm(chain.residuals(*chain.closed_form()) * chain.weights, axis=1)))


def _from_mm(X: Array) -> Array:
    return rigid(X[:, :3, :3], 1e-3 * X[:, :3, 3])

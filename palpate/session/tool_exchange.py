"""Changes the instrument of a follower: which instruments fit, when the exchange is possible, the scene afterwards.

The steps are those at a patient-side arm: everything holds, the tool is out of the tissue, the instrument is removed
through the trocar and another one is mounted. It comes in with closed jaws, which do not open by themselves.
"""

from __future__ import annotations

import numpy as np

from palpate.arm import INSTRUMENTS, Arm
from palpate.base.errors import SceneError, StateError
from palpate.record.ticks import Ticks
from palpate.scene.overrides import override
from palpate.scene.scene import Scene
from palpate.session import machine

_OF_ARM = 3  # joints of a patient-side arm that an exchange leaves: yaw, pitch, insertion


def mounted(scene: Scene, model: str, pair: str = "") -> Scene:
    """The scene with another instrument on the follower.

    The new jaws start closed, or at zero where they can press on each other, and open only after the pinch has closed
    to their angle (`mapping.ratchet`).

    Args:
        scene: the scene.
        model: model of the arm with the new instrument, such as ``psm_prograsp``, or a model file.
        pair: name of the pair; empty for a scene of one pair.

    Raises:
        StateError: there is no such instrument, it is mounted already, or it does not fit the arm or the scene.
    """
    one = scene.pair(pair) if pair else scene
    before = one.arm("follower")
    root = f"pairs.{pair}." if pair else ""
    try:
        found = override(scene, {f"{root}arms.follower.model": model})
        after = (found.pair(pair) if pair else found).arm("follower")
    except SceneError as error:
        raise StateError(f"there is no instrument {model!r}: {error.what}", why=error.why, mend=_list()) from None
    if after.name == before.name:
        raise StateError(f"{model!r} is mounted already", mend=_list())
    _require_fit(before, after)
    low = one.arms.follower.jaw.closed
    return override(found, {f"{root}arms.follower.jaw.start": max(low, 0.0), f"{root}mapping.ratchet": True})


def require_still(tick: Ticks, running: bool, pair: str = "") -> None:
    """Refuse an exchange while an arm of the session moves or a hand feels a force.

    Args:
        tick: the newest tick of the pair.
        running: True if the session runs in real time.
        pair: name of the pair for the message; empty for the only one.

    Raises:
        StateError: the session runs, does not hold, or still pushes the hand.
    """
    of, state = _of(pair), machine.name_of(float(tick["session_state"]))
    if running:
        mend = "call console.begin_tool_exchange(), wait until the force is zero, and stop()"
        raise StateError(f"an instrument cannot be exchanged while the session{of} runs", mend=mend)
    if state != "hold":
        mend = "call console.begin_tool_exchange(), and let the session take a tick"
        raise StateError(f"an instrument cannot be exchanged: the session{of} is {state}", mend=mend)
    if np.any(tick["F_H_L"]):
        force = float(np.linalg.norm(tick["F_H_L"]))
        mend = "let the session hold for some tenths of a second more"
        raise StateError(f"the hand{of} still feels {force:.2f} N, which ramps to zero", mend=mend)


def require_free(tick: Ticks, pair: str = "") -> None:
    """Refuse to remove an instrument that is in tissue or carries the rod; arguments and errors as `require_still`."""
    if float(tick["contacts"]) > 0:
        why = f"it is {1e3 * float(tick['depth']):.1f} mm deep"
        mend = "end the exchange, draw the tool back along its shaft until it is free, and begin again"
        raise StateError(f"the instrument{_of(pair)} touches an object", why=why, mend=mend)
    if float(tick["holding"]) > 0:
        mend = "end the exchange, open the jaws or hand the object over, and begin again"
        raise StateError(f"the instrument{_of(pair)} holds an object", mend=mend)


def _require_fit(before: Arm, after: Arm) -> None:
    """Refuse a model whose arm is another than the present one."""
    k = _OF_ARM
    same = (
        before.joint_names == after.joint_names
        and before.has_remote_centre == after.has_remote_centre
        and np.array_equal(before.q_min[:k], after.q_min[:k])
        and np.array_equal(before.q_max[:k], after.q_max[:k])
    )
    if not same:
        why = (
            f"its joints are {', '.join(after.joint_names)}; those of {before.name} are {', '.join(before.joint_names)}"
        )
        what = f"{after.name} is no instrument for the arm of {before.name}"
        raise StateError(what, why=why, mend=_list())


def _list() -> str:
    return (
        f"instruments of the PSM: {', '.join(f'psm_{name}' for name in INSTRUMENTS)}; or a model file of the same arm"
    )


def _of(pair: str) -> str:
    return f" of pair {pair}" if pair else ""

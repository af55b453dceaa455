"""Roles of enclaves: which topics a process with a key may publish, and which it may hear.

The names are those of topics; `*` stands for the arm or any other part. The last part of an enclave's name is its role,
unless it is given as NAME=ROLE.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

from palpate.base.errors import PalpateError

_MEASURED = (
    "*/measured_*",
    "*/setpoint_*",
    "*/operating_state",
    "*/goal_reached",
    "*/tool_type",
    "*/tool_type_request",
)
_TELEOP = ("*/following", "*/scale", "*/current_state", "*/alignment_offset")
_CONSOLE = ("console/*", "footpedals/*", "arm_clutch")
_PICTURE = ("tf", "tf_static")
_OWN = ("rosout", "parameter_events", "clock")


@dataclass(frozen=True)
class Role:
    """What a kind of process may do."""

    publish: tuple[str, ...]
    subscribe: tuple[str, ...]
    serve: tuple[str, ...] = ()  #: names of services that it answers
    call: tuple[str, ...] = ()  #: names of services that it asks


@cache
def roles() -> dict[str, Role]:
    """The roles by name."""
    from palpate import _dvrk

    said = tuple(sorted({f"*/{name}" for _, _, name, *_ in _dvrk.topics()}))
    heard = tuple(sorted({f"*/{name}" for _, _, name, *_ in _dvrk.verbs()}))
    measures = (
        "*/measured_*",
        "*/setpoint_*",
        "*/body/jacobian",
        "*/spatial/jacobian",
        "*/alignment_offset",
        "stats/*",
        "publishers/period_statistics",
    )
    haptics = Role(
        publish=(
            *("*/following/mtm/body/servo_cf", "*/body/servo_cf", "*/body/set_cf_orientation_absolute"),
            *("*/use_gravity_compensation", "*/servo_cp", "*/jaw/servo_jp", "diagnostics", "palpate/*", *_PICTURE),
        ),
        subscribe=(
            *(*_MEASURED, *_TELEOP, *_CONSOLE, *_PICTURE, "*/body/servo_cf", "*/body/set_cf_orientation_absolute"),
            *("*/use_gravity_compensation", "*/points", "palpate/*"),
        ),
        serve=("palpate/*", "palpate_*"),
    )
    move = Role(
        publish=("*/servo_jp", "*/move_jp", "*/hold", "*/trajectory_j/set_ratio_v", "*/trajectory_j/set_ratio_a"),
        subscribe=(*_MEASURED, "*/trajectory_j/ratio*", "palpate_move/*"),
    )
    robot = Role(
        publish=(*said, *measures, *_PICTURE),
        subscribe=heard,
        serve=("*/forward_kinematics", "*/inverse_kinematics", "*/actuator_to_joint_position"),
    )
    camera = Role(publish=("*/points", "*/depth/image_rect_raw", "*/depth/camera_info", *_PICTURE), subscribe=())
    return {
        "haptics": haptics,
        "sim": robot,
        "robot": robot,
        "camera": camera,
        "move": move,
        "watch": Role(publish=(), subscribe=("*",)),
        "all": Role(publish=("*",), subscribe=("*",), serve=("*",), call=("*",)),
    }


WORDS = {
    "haptics": "the haptic node, with its guardian",
    "sim": "the simulated robot",
    "robot": "a real robot's CRTK bridge",
    "camera": "a camera: clouds, depth pictures and frames alone",
    "move": "palpate ros move",
    "watch": "hears everything and publishes nothing: palpate ros topic echo, RViz, ros2 bag record",
    "all": "everything: a client of your own; give it to no machine that others use",
}
"""What each role is for."""


def role_of(enclave: str) -> tuple[str, Role]:
    """Name of an enclave and its role, from ``/palpate/camera`` or ``/lab/left=camera``.

    Raises:
        PalpateError: the name is invalid, or its role is unknown.
    """
    name, _, kind = enclave.partition("=")
    if not name.startswith("/") or ".." in name or name.endswith("/") or not name.replace("/", "").isidentifier():
        mend = "use /, letters, digits and _, e.g. /palpate/haptics"
        raise PalpateError(f"{name!r} is no enclave name", mend=mend)
    kind = kind or name.rpartition("/")[2]
    if kind not in roles():
        known = "; ".join(f"{role}: {words}" for role, words in WORDS.items())
        raise PalpateError(f"{kind!r} is no role of an enclave", why=known, mend=f"write e.g. {name}=camera")
    return name, roles()[kind]


def topics(role: Role) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Names of the DDS topics that a role may publish, and those that it may hear."""
    common = ("ros_discovery_info", *(f"rt/{name}" for name in _OWN))
    said = (*common, *(f"rt/{name}" for name in role.publish), *(f"rr/{name}Reply" for name in role.serve))
    heard = (*common, *(f"rt/{name}" for name in role.subscribe), *(f"rq/{name}Request" for name in role.serve))
    said += tuple(f"rq/{name}Request" for name in role.call)
    heard += tuple(f"rr/{name}Reply" for name in role.call)
    return said, heard

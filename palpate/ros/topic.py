"""Replaces `ros2 topic` in an environment without it: list, echo, hz and pub, over rclpy."""

from __future__ import annotations

import importlib
import re
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import yaml

from palpate import ros
from palpate.base.errors import PalpateError

_PACKAGE = re.compile(r"[a-z][a-z0-9_]*")  # name of a ROS package
FIND = 3.0
"""Timeout for finding a topic [s]."""


@contextmanager
def node(network: bool = False, name: str = "palpate_topic") -> Iterator[Any]:
    """Context manager for a node of this name; limited to this machine unless `network`."""
    native = ros.load()
    here = native.Context(network=network)  # sets how far discovery reaches
    import rclpy
    from rclpy.context import Context

    context = Context()
    rclpy.init(context=context, domain_id=here.domain)
    made = rclpy.create_node(name, context=context, enable_rosout=False)
    try:
        yield made
    finally:
        if hasattr(made, "palpate_executor"):
            made.palpate_executor.shutdown()
        made.destroy_node()
        rclpy.shutdown(context=context)


def topics(here: Any, seconds: float = 1.0) -> list[tuple[str, str]]:
    """Names and types of all topics, after a discovery of `seconds` [s]."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        spin(here, 0.05)
    return sorted((name, types[0]) for name, types in here.get_topic_names_and_types())


def listen(here: Any, topic: str, take: Callable[[Any], None], count: int | None, seconds: float | None) -> int:
    """Call back with each message; returns the number of messages.

    Args:
        here: a node.
        topic: full name.
        take: called with each message.
        count: end after this number of messages.
        seconds: end after this time [s].

    Raises:
        PalpateError: nobody publishes the topic.
    """
    kind, quality = publisher_type(here, topic)
    received = 0

    def receive(message: Any) -> None:
        nonlocal received
        if count is None or received < count:
            received += 1
            take(message)

    here.create_subscription(kind, topic, receive, quality)
    end = np.inf if seconds is None else time.monotonic() + seconds
    while (count is None or received < count) and time.monotonic() < end:
        spin(here, 0.1)
    return received


def publish(here: Any, topic: str, type_name: str, text: str, rate: float | None) -> None:
    """Publish a message given as YAML: once after a subscriber is found, or at `rate` [Hz] until Ctrl-C.

    Raises:
        PalpateError: the type or a field does not exist, or nobody subscribes.
    """
    kind = message_type(type_name)
    message = kind()
    fill(message, yaml.safe_load(text) or {})
    publisher = here.create_publisher(kind, topic, 10)
    end = time.monotonic() + FIND
    while not publisher.get_subscription_count():
        if time.monotonic() > end:
            raise PalpateError(f"nobody listens to {topic}", mend="check the name with `palpate ros topic list`")
        spin(here, 0.02)
    while True:
        if hasattr(message, "header") and not (message.header.stamp.sec or message.header.stamp.nanosec):
            message.header.stamp = here.get_clock().now().to_msg()
            stamped = True
        else:
            stamped = False
        publisher.publish(message)
        spin(here, 0.05 if rate is None else 1.0 / rate)
        if rate is None:
            publisher.wait_for_all_acked()
            return
        if stamped:
            message.header.stamp.sec = message.header.stamp.nanosec = 0


def message_type(name: str) -> Any:
    """``geometry_msgs/msg/WrenchStamped`` (or without ``msg``) as a class.

    Raises:
        PalpateError: the type does not exist.
    """
    package, _, kind = name.replace("/msg/", "/").partition("/")
    try:
        if not _PACKAGE.fullmatch(package) or not kind.isidentifier():  # the name may come from the network
            raise ValueError
        return getattr(importlib.import_module(f"{package}.msg"), kind)
    except (ImportError, AttributeError, ValueError):
        raise PalpateError(
            f"there is no message type {name!r}", mend="give package/msg/Type, e.g. std_msgs/msg/Bool"
        ) from None


def as_plain(message: Any) -> Any:
    """A message as dictionaries, lists and numbers."""
    if hasattr(message, "get_fields_and_field_types"):
        return {name: as_plain(getattr(message, name)) for name in message.get_fields_and_field_types()}
    if isinstance(message, np.ndarray) or (not isinstance(message, str | bytes) and hasattr(message, "__iter__")):
        return [as_plain(value) for value in message]
    return message


def fill(message: Any, values: dict[str, Any]) -> None:
    """Set the fields of a message that `values` names.

    Raises:
        PalpateError: a field does not exist, or a value has the wrong type.
    """
    fields = message.get_fields_and_field_types()
    for name, value in values.items():
        if name not in fields:
            raise PalpateError(f"{type(message).__name__} has no field {name!r}", mend=f"fields: {', '.join(fields)}")
        held = getattr(message, name)
        if hasattr(held, "get_fields_and_field_types"):
            fill(held, value)
            continue
        try:
            setattr(message, name, type(held)(value) if isinstance(held, float | int | str) else value)
        except (AssertionError, TypeError, ValueError) as error:
            why = str(error).splitlines()[0]
            raise PalpateError(f"{name}: {value!r} does not fit {fields[name]}", why=why) from None


def publisher_type(here: Any, topic: str) -> tuple[Any, Any]:
    """Type of a topic, and a quality of service that is compatible with its publishers.

    Raises:
        PalpateError: nobody publishes the topic, or its type is not known here.
    """
    from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

    end = time.monotonic() + FIND
    while not (ends := here.get_publishers_info_by_topic(topic)):
        if time.monotonic() > end:
            raise PalpateError(f"nobody publishes {topic}", mend="check the name with `palpate ros topic list`")
        spin(here, 0.02)
    reliable = all(e.qos_profile.reliability == ReliabilityPolicy.RELIABLE for e in ends)
    latched = all(e.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL for e in ends)
    quality = QoSProfile(
        depth=100,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )
    return message_type(ends[0].topic_type), quality


def spin(here: Any, seconds: float) -> None:
    """Handle one message of a node, which arrives within a time [s]."""
    from rclpy.executors import SingleThreadedExecutor

    if not hasattr(here, "palpate_executor"):
        here.palpate_executor = SingleThreadedExecutor(context=here.context)
        here.palpate_executor.add_node(here)
    here.palpate_executor.spin_once(timeout_sec=seconds)

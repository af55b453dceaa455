"""Lists of fixtures: conversion to and from YAML, and unique names."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated

from pydantic import BeforeValidator, Field

from palpate.scene.guidance.fixture import Fixture
from palpate.scene.guidance.one_line import expand_list

FixtureList = Annotated[tuple[Fixture, ...], Field(max_length=128), BeforeValidator(expand_list)]
"""The list ``guidance`` of a scene, with a tube for every plan that is followed."""


def from_yaml(text: str) -> tuple[Fixture, ...]:
    """Fixtures from a YAML list; each item is a section or one line of text.

    Raises:
        GuidanceError: the text is invalid; the message names the first error.
    """
    from palpate.scene.guidance import yaml_text

    return yaml_text.from_yaml(text, Fixture)


def to_yaml(guidance: Iterable[Fixture]) -> str:
    """A YAML list of fixtures, without the keys that have their default values."""
    from palpate.scene.guidance import yaml_text

    return yaml_text.to_yaml(guidance)


def with_unique_names(guidance: tuple[Fixture, ...]) -> tuple[Fixture, ...]:
    """The fixtures with unique names. A missing name becomes the role, numbered if that name is taken.

    Raises:
        ValueError: two fixtures are given the same name.
    """
    out: list[Fixture] = []
    for i, fixture in enumerate(guidance):
        name, taken = fixture.name or fixture.role.name, [f.name for f in out]
        if name in taken and fixture.name:
            raise ValueError(f"two fixtures are named {name!r} | give each fixture its own name")
        out.append(fixture.model_copy(update={"name": f"{name}-{i + 1}" if name in taken else name}))
    return tuple(out)

"""Lists of fixtures: as YAML and back, each with a name of its own."""

from __future__ import annotations

from palpate.guidance import yaml_text
from palpate.guidance.fixture import Fixture
from palpate.guidance.yaml_text import to_yaml

__all__ = ["from_yaml", "named", "to_yaml"]


def from_yaml(text: str) -> tuple[Fixture, ...]:
    """Fixtures from a list of YAML, of sections or of lines.

    Raises:
        GuidanceError: the text holds no fixtures; names the first mistake.
    """
    return yaml_text.from_yaml(text, Fixture)


def named(guidance: tuple[Fixture, ...]) -> tuple[Fixture, ...]:
    """Each with a name of its own: its role where none is given, and a number where one is taken.

    Raises:
        ValueError: two were given the same name.
    """
    out: list[Fixture] = []
    for i, fixture in enumerate(guidance):
        name, taken = fixture.name or fixture.role.name, [f.name for f in out]
        if name in taken and fixture.name:
            raise ValueError(f"two fixtures are named {name!r} | give each fixture its own name")
        out.append(fixture.model_copy(update={"name": f"{name}-{i + 1}" if name in taken else name}))
    return tuple(out)

"""Lists of fixtures: as YAML and back, each with a name of its own."""

from __future__ import annotations

from collections.abc import Iterable

import yaml
from pydantic import TypeAdapter, ValidationError

from palpate.errors import GuidanceError
from palpate.guidance import one_line
from palpate.guidance.fixture import Fixture


def to_yaml(fixtures: Iterable[Fixture]) -> str:
    """A scene's list ``guidance``: what differs from the defaults."""
    data = [f.model_dump(mode="json", exclude_defaults=True) for f in fixtures]
    return str(yaml.safe_dump(data, sort_keys=False, allow_unicode=True, default_flow_style=None, width=110))


def from_yaml(text: str) -> tuple[Fixture, ...]:
    """Fixtures from a list of YAML, of sections or of lines.

    Raises:
        GuidanceError: it is none; names the first mistake.
    """
    try:
        data = yaml.safe_load(one_line.readable(text))
        return TypeAdapter(tuple[Fixture, ...]).validate_python(data if isinstance(data, list) else [data])
    except yaml.YAMLError as error:
        raise GuidanceError("not valid YAML", why=" ".join(str(error).split()), mend="a list of fixtures") from None
    except ValidationError as error:
        from palpate.scene.explain import spell

        first = error.errors(include_url=False)[0]
        where = spell(tuple(first["loc"]))
        if "error" in first.get("ctx", {}):
            what, _, mend = str(first["ctx"]["error"]).partition(" | ")
            raise GuidanceError(f"{where}: {what}", mend=mend) from None
        expected = first["msg"].replace("Input should be", "must be")
        raise GuidanceError(f"{where} = {first['input']!r:.60}", mend=expected) from None


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

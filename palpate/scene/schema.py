"""The JSON Schema of scene files, with which editors complete and check them."""

from __future__ import annotations

import json
from typing import Any

from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue

from palpate.base.values.descriptions import descriptions, unit_of
from palpate.scene.scene import Scene


class _Described(GenerateJsonSchema):
    """Adds a description to each property, and text with a unit to each number that has one."""

    def model_schema(self, schema: Any) -> JsonSchemaValue:
        """The schema of one section."""
        made = super().model_schema(schema)
        for name, text in descriptions(schema["cls"]).items():
            if name in made.get("properties", {}):
                if unit_of(schema["cls"], name):
                    made["properties"][name] = _with_unit(made["properties"][name])
                made["properties"][name].setdefault("description", text)
        return made


def _with_unit(schema: Any) -> Any:
    """The schema, with text such as ``2 mm`` in the place of each number."""
    if isinstance(schema, list):
        return [_with_unit(item) for item in schema]
    if not isinstance(schema, dict):
        return schema
    if schema.get("type") == "number":
        outer = {key: schema[key] for key in ("default", "title") if key in schema}
        number = {key: value for key, value in schema.items() if key not in outer}
        return {"anyOf": [number, {"type": "string", "pattern": r"\d\s*[a-zA-Z]"}], **outer}
    return {key: _with_unit(value) if key != "default" else value for key, value in schema.items()}


def schema_text() -> str:
    """Text of the schema, as published in ``docs/scene.schema.json``."""
    schema = Scene.model_json_schema(schema_generator=_Described)
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    schema["title"] = "Palpate scene"
    return json.dumps(schema, indent=2) + "\n"

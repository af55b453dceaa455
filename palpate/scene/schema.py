"""The JSON Schema of scene files, with which editors complete and check them."""

from __future__ import annotations

import json
from typing import Any

from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue

from palpate.scene.descriptions import descriptions
from palpate.scene.scene import Scene


class _Described(GenerateJsonSchema):
    """Adds a description to each property."""

    def model_schema(self, schema: Any) -> JsonSchemaValue:
        """The schema of one section."""
        made = super().model_schema(schema)
        for name, text in descriptions(schema["cls"]).items():
            if name in made.get("properties", {}):
                made["properties"][name].setdefault("description", text)
        return made


def schema_text() -> str:
    """Text of the schema, as published in ``docs/scene.schema.json``."""
    schema = Scene.model_json_schema(schema_generator=_Described)
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    schema["title"] = "Palpate scene"
    return json.dumps(schema, indent=2) + "\n"

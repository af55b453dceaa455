"""The JSON Schema of scene files, for editors that complete and check them."""

from __future__ import annotations

import json

from palpate.scene.scene import Scene


def schema_text() -> str:
    """The schema as it is published in ``docs/scene.schema.json``."""
    schema = Scene.model_json_schema()
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    schema["title"] = "Palpate scene"
    return json.dumps(schema, indent=2) + "\n"

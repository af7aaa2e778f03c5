# SPDX-License-Identifier: Apache-2.0
"""The properties of findings, as the schema of records lists them."""

import json
import pathlib

SCRIPTS = pathlib.Path(__file__).resolve().parent.parent
PLACES = (SCRIPTS.parent / "json", SCRIPTS)  # of the repository, and installed
SEVERAL = "several findings: "  # what a report says of the first and the last one


def read_properties():
    """Returns none if assay-run was copied without the schema."""
    for path in (place / "findings.schema.json" for place in PLACES):
        if path.is_file():
            return json.loads(path.read_text(encoding="utf-8"))["$defs"]["finding"]["properties"]
    return {}


PROPERTIES = {key: schema for key, schema in read_properties().items() if isinstance(schema, dict)}
COUNTS = tuple(key for key, schema in PROPERTIES.items() if schema.get("$ref") == "#/$defs/count")
RANGES = {key: schema["$comment"].removeprefix(SEVERAL) for key, schema in PROPERTIES.items() if "$comment" in schema}

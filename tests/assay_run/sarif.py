# SPDX-License-Identifier: Apache-2.0
"""A schema of those parts of SARIF 2.1.0 that assay-run writes, and that code scanning reads. The
numbers are sections of the specification."""


def members(required="", **properties):
    """An object with these members and no others."""
    return {"type": "object", "required": required.split(), "additionalProperties": False,
            "properties": properties}


def array(items, **more):
    return {"type": "array", "items": items, **more}


TEXT, NAME = {"type": "string"}, {"type": "string", "minLength": 1}
LEVEL = {"enum": ["none", "note", "warning", "error"]}
REFERENCE = {"type": "string", "pattern": "^([A-Za-z0-9._~!$&'()*+,;=:@/-]|%[0-9A-Fa-f]{2})+$"}
MESSAGE = members("text", text=NAME)  # 3.11
RULE = members("id", id=NAME, fullDescription=MESSAGE,
               helpUri={"type": "string", "pattern": "^https://[!-~]+$"})  # 3.49
DRIVER = members("name", name=NAME, version=NAME, rules=array(RULE, uniqueItems=True))  # 3.19
NOTIFICATION = members("message", level=LEVEL, message=MESSAGE)
INVOCATION = members("executionSuccessful", executionSuccessful={"type": "boolean"}, commandLine=TEXT,
                     toolExecutionNotifications=array(NOTIFICATION))  # 3.20
PLACE = members("artifactLocation",  # 3.29
                artifactLocation=members("uri", uri=REFERENCE, uriBaseId=TEXT),  # 3.4
                region=members(startLine={"type": "integer", "minimum": 1}))  # 3.30
LOCATION = members("physicalLocation", physicalLocation=PLACE,  # 3.28
                   logicalLocations=array(members(name=TEXT, kind=TEXT), uniqueItems=True))  # 3.33
FRAME = members(location=members(message=MESSAGE, physicalLocation=PLACE), module=TEXT)  # 3.45
STACK = members("frames", message=MESSAGE, frames=array(FRAME))  # 3.44
SUPPRESSION = members("kind", kind={"enum": ["inSource", "external"]}, justification=TEXT)
RESULT = members("ruleId message locations", ruleId=NAME, level=LEVEL, message=MESSAGE,  # 3.27
                 locations=array(LOCATION, minItems=1),  # code scanning wants one in each result
                 stacks=array(STACK, uniqueItems=True), suppressions=array(SUPPRESSION),
                 occurrenceCount={"type": "integer", "minimum": 1},
                 partialFingerprints={"type": "object", "additionalProperties": TEXT})
RUN = members("tool results", tool=members("driver", driver=DRIVER), invocations=array(INVOCATION),
              results=array(RESULT))  # 3.14
SARIF = {"$schema": "https://json-schema.org/draft/2020-12/schema",
         **members("version runs", **{"$schema": {"type": "string", "format": "uri"}},
                   version={"const": "2.1.0"}, runs=array(RUN, minItems=1))}  # 3.13

#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes what other files say of the rows of src/report/properties.def, or checks it: the properties of
findings in json/findings.schema.json. Fails if a file differs; with --write it is rewritten."""

import argparse
import json
import pathlib
import re
import sys

COMMENT = re.compile(r"/\*.*?\*/", re.S)
TOKEN = re.compile(r'"(?:\\.|[^"\\])*"|.', re.S)


def read_rows(path):
    """Yields each row of a table as (macro, arguments); strings of C are joined."""
    text = COMMENT.sub("", path.read_text(encoding="utf-8"))
    text = re.sub(r"^#.*$", "", text, flags=re.M)
    for start in re.finditer(r"^([A-Z_]+)\(", text, re.M):
        arguments, depth = [""], 1
        for token in TOKEN.finditer(text, start.end()):
            depth += (token[0] == "(") - (token[0] == ")")
            if not depth:
                break
            if token[0] == "," and depth == 1:
                arguments.append("")
            else:
                arguments[-1] += token[0]
        yield start[1], [join_strings(argument.strip()) for argument in arguments]


def join_strings(argument):
    parts = re.findall(r'"(?:\\.|[^"\\])*"', argument)
    if not parts or re.sub(r'"(?:\\.|[^"\\])*"|\s', "", argument):
        return argument
    return "".join(map(json.loads, parts))


# ---- properties of findings

def schema_of(kind, about, span=""):
    schema = {"description": about} if about else {}
    if span:
        schema["$comment"] = f"several findings: {span}"
    return schema | ({"type": "string"} if kind == "text" else {"$ref": f"#/$defs/{kind}"})


def finding_schemas(root):
    """Returns the schemas of the properties by key, the keys that each finding has, and those with a range."""
    schemas, required, ranged = {}, [], []
    for macro, row in read_rows(root / "src/report/properties.def"):
        if macro == "LABELS" or row[0] == "NULL":
            continue
        span = row[6] if macro == "PLACE" else ""
        schemas[row[0]] = schema_of(row[1], row[-1], span)
        required += [row[0]] if row[2] == "true" else []
        ranged += [row[0]] if span else []
    return schemas, required, ranged


def member_lines(schemas):
    return "".join(f'        "{key}": {{ {json.dumps(schema)[1:-1]} }},\n' for key, schema in schemas.items())


def write_schema(root, text):
    schemas, required, ranged = finding_schemas(root)
    begin = text.index('        "Severity": ')
    end = text.index('        "pid": true', begin)
    text = text[:begin] + member_lines(schemas) + text[end:]
    required_at = text.index('"required": [', begin) + len('"required": ')
    text = text[:required_at] + json.dumps(required) + text[text.index("]", required_at) + 1:]
    records = member_lines({key: {"$ref": f"#/$defs/finding/properties/{key}"} for key in ranged})
    return re.sub(r'(        "\w+": \{ "\$ref": "#/\$defs/finding/properties/\w+" \},\n)+', lambda _: records, text)


# ---- all files

FILES = {"json/findings.schema.json": write_schema}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("root", nargs="?", type=pathlib.Path, default=pathlib.Path.cwd(),
                        help="of the repository (default: the working directory)")
    parser.add_argument("--write", action="store_true", help="write the files")
    arguments = parser.parse_args()
    stale = []
    for name, write in FILES.items():
        path = arguments.root / name
        text = path.read_text(encoding="utf-8")
        wanted = write(arguments.root, text)
        if wanted != text:
            stale.append(name)
        if wanted != text and arguments.write:
            path.write_text(wanted, encoding="utf-8")
    if stale and not arguments.write:
        print("\n".join(f"{name}: differs from the tables; scripts/lint --tables --fix rewrites it" for name in stale))
    elif not arguments.write:
        print(f"tables: {', '.join(FILES)} {'are' if len(FILES) > 1 else 'is'} up to date")
    sys.exit(1 if stale and not arguments.write else 0)


if __name__ == "__main__":
    main()

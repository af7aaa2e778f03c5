#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs a program with log_format = json, and validates each line against the schema.

usage: schema_test.py SCHEMA PROGRAM [ARGUMENT...]

Exits with 77 (skipped) if python3-jsonschema is missing, or if the program is skipped."""

import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

try:
    import jsonschema
except ImportError:
    print("python3-jsonschema is missing")
    sys.exit(77)

CONTROL = re.compile(r"[\x00-\x1f]")


class Failure(Exception):
    pass


class Checker:
    def __init__(self, schema):
        jsonschema.Draft202012Validator.check_schema(schema)
        self.validators = {}
        for entry in schema["oneOf"]:
            name = entry["$ref"].rsplit("/", 1)[1]
            of_kind = {**schema, "oneOf": [entry]}
            kind = schema["$defs"][name]["properties"]["Type"]
            for word in kind.get("enum", [kind.get("const")]):
                self.validators[word] = jsonschema.Draft202012Validator(of_kind)

    def check_line(self, data, where):
        """Returns the line's object."""
        if CONTROL.search(data.decode("utf-8", "strict")):
            raise Failure(f"{where}: a control character is not escaped")
        line = json.loads(data)
        kind = line.get("Type")
        if kind not in self.validators:
            raise Failure(f"{where}: no Type: {data[:200]!r}")
        for error in self.validators[kind].iter_errors(line):
            raise Failure(f"{where}: {error.message}: {data[:2000]!r}")
        return line


def check_file(checker, path):
    """Returns the lines of a file, which has whole instances, one after another or interleaved."""
    content = path.read_bytes()
    if not content.endswith(b"\n"):
        raise Failure(f"{path.name}: the last line is cut")
    lines = [checker.check_line(data, f"{path.name}:{number}")
             for number, data in enumerate(content[:-1].split(b"\n"), 1)]
    kinds = [line["Type"] for line in lines]
    if kinds[0] != "Header" or kinds[-1] != "Summary":
        raise Failure(f"{path.name}: from {kinds[0]} to {kinds[-1]}, not from Header to Summary")
    if kinds.count("Header") != kinds.count("Summary"):
        raise Failure(f"{path.name}: {kinds.count('Header')} headers, "
                      f"but {kinds.count('Summary')} summaries")
    return lines


def check_counts(lines):
    """The summaries count the findings that were sent and those that were held back."""
    found, held, sent = {}, {}, {}
    for line in lines:
        for counts, key in ((found, "Findings"), (held, "HeldBack")):
            for name, count in line.get(key, {}).items():
                counts[name] = counts.get(name, 0) + count
        if line["Type"] == "Finding" and "level" in line:
            sent[line["VUID"]] = sent.get(line["VUID"], 0) + 1
    total = {name: sent.get(name, 0) + held.get(name, 0) for name in {*sent, *held}}
    if total != found:
        differing = {name: (total.get(name), found.get(name)) for name in {*total, *found}
                     if total.get(name) != found.get(name)}
        raise Failure(f"counts of lines and of summaries differ: {differing}")


def main():
    schema = json.loads(pathlib.Path(sys.argv[1]).read_text(encoding="utf-8"))
    checker = Checker(schema)
    with tempfile.TemporaryDirectory() as folder:
        environment = {**os.environ, "VK_ASSAY_VALIDATION_LOG_FORMAT": "json",
                       "VK_ASSAY_VALIDATION_LOG_FILENAME": f"{folder}/%e-%p.jsonl"}
        run = subprocess.run(sys.argv[2:], env=environment, stdout=subprocess.DEVNULL, check=False)
        if run.returncode:
            return run.returncode
        files = sorted(pathlib.Path(folder).iterdir())
        name = re.compile(re.escape(pathlib.Path(sys.argv[2]).name) + r"-\d+\.jsonl")
        if not files or not all(name.fullmatch(file.name) for file in files):
            raise Failure(f"the files are {[file.name for file in files]}")
        lines = [line for file in files for line in check_file(checker, file)]
    check_counts(lines)
    findings = [line for line in lines if line["Type"] == "Finding"]
    if not findings:
        raise Failure("there are no findings")
    print(f"{len(lines)} lines of {len(files)} processes, {len(findings)} findings: valid")
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except Failure as failure:
        print(failure)
        sys.exit(1)

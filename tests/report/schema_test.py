# SPDX-License-Identifier: Apache-2.0
"""Runs a program with log_format = json, and validates each line against the schema.

usage: schema_test.py [--one-file] [--call-sites MODE] [--findings N] [--records N]
                      SCHEMA PROGRAM [ARGUMENT...]

  --one-file    the processes write one file
  --findings N  there are exactly so many
  --call-sites MODE
                sets call_sites; each finding of a rule has a call site that begins in the program
  --records N   with record_builds = true; the lines have at least N modes and types of builds and
                copies

Exits with 77 (skipped) if python3-jsonschema is missing, or if the program is skipped."""

import argparse
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


def check_instances(lines, where):
    """The lines of one process are from the header of an instance to its summary."""
    kinds = [line["Type"] for line in lines]
    if kinds[0] != "Header":
        raise Failure(f"{where}: the first line is {kinds[0]}")
    if kinds.count("Summary") != kinds.count("Header"):
        raise Failure(f"{where}: {kinds.count('Header')} headers, "
                      f"but {kinds.count('Summary')} summaries")
    if kinds[-1] != "Summary":
        raise Failure(f"{where}: the last line is {kinds[-1]}")


def check_file(checker, path):
    """Returns the lines of a file."""
    content = path.read_bytes()
    if not content.endswith(b"\n"):
        raise Failure(f"{path.name}: the last line is cut")
    lines = [checker.check_line(data, f"{path.name}:{number}")
             for number, data in enumerate(content[:-1].split(b"\n"), 1)]
    processes = {}
    for line in lines:
        processes.setdefault(line["pid"], []).append(line)
    for process, of_process in processes.items():
        check_instances(of_process, f"{path.name}, process {process}")
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


def check_call_sites(lines, program):
    for line in lines:
        if line["Type"] != "Finding" or "level" not in line:
            continue
        module = line.get("call_site", [{"module": None}])[0]["module"]
        if module != program:
            raise Failure(f"the call site begins in {module}: {line}")


def check_records(lines, least):
    """What a queue executes belongs to a submission that has a line before."""
    submitted, kinds = set(), set()
    for line in lines:
        place = line["pid"], line.get("device"), line.get("queue"), line.get("submission")
        if line["Type"] == "Header":
            submitted.clear()  # handles may be used again
        elif line["Type"] == "Submission":
            submitted.add(place)
        elif line["Type"] in ("Build", "Copy"):
            kinds.add((line["mode"], line["type"], "queue" in line))
            if "queue" in line and place not in submitted:
                raise Failure(f"no submission before: {line}")
    if least and all(line["Type"] != "Device" for line in lines):
        raise Failure("no line is about the device")
    if len(kinds) < least:
        raise Failure(f"only {len(kinds)} kinds of builds and copies: {sorted(kinds)}")


def read_arguments():
    parser = argparse.ArgumentParser()
    parser.add_argument("--one-file", action="store_true")
    parser.add_argument("--call-sites")
    parser.add_argument("--findings", type=int)
    parser.add_argument("--records", type=int, default=0)
    parser.add_argument("--emulator", default="")
    parser.add_argument("schema", type=pathlib.Path)
    parser.add_argument("command", nargs=argparse.REMAINDER)
    return parser.parse_args()


def main():
    arguments = read_arguments()
    checker = Checker(json.loads(arguments.schema.read_text(encoding="utf-8")))
    program = pathlib.Path(arguments.command[0]).name
    filename = "%e.jsonl" if arguments.one_file else "%e-%p.jsonl"
    expected = re.escape(program) + (r"\.jsonl" if arguments.one_file else r"-\d+\.jsonl")
    with tempfile.TemporaryDirectory() as folder:
        environment = {**os.environ, "VK_ASSAY_VALIDATION_LOG_FORMAT": "json",
                       "VK_ASSAY_VALIDATION_LOG_FILENAME": f"{folder}/{filename}"}
        if arguments.call_sites:
            environment["VK_ASSAY_VALIDATION_CALL_SITES"] = arguments.call_sites
        if arguments.records:
            environment["VK_ASSAY_VALIDATION_RECORD_BUILDS"] = "true"
        if arguments.findings:
            environment["VK_ASSAY_VALIDATION_DUPLICATE_MESSAGE_LIMIT"] = "0"
        run = subprocess.run(arguments.emulator.split() + arguments.command, env=environment, stdout=subprocess.DEVNULL,
                             check=False)
        if run.returncode:
            return run.returncode
        files = sorted(pathlib.Path(folder).iterdir())
        if not files or not all(re.fullmatch(expected, file.name) for file in files):
            raise Failure(f"the files are {[file.name for file in files]}")
        lines = [line for file in files for line in check_file(checker, file)]
    check_counts(lines)
    if arguments.call_sites:
        check_call_sites(lines, str(pathlib.Path(arguments.command[0]).resolve()))
    check_records(lines, arguments.records)
    findings = [line for line in lines if line["Type"] == "Finding"]
    if not findings or arguments.findings not in (None, len(findings)):
        raise Failure(f"there are {len(findings)} findings")
    print(f"{len(lines)} lines in {len(files)} files, {len(findings)} findings: valid")
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except Failure as failure:
        print(failure)
        sys.exit(1)

# SPDX-License-Identifier: Apache-2.0
"""Baselines: known findings, one a line.

A line is an id, or an id with a condition. # begins a comment.
  ID@GLOB       matches the debug name of one of the finding's objects, or one of its labels
  ID@fn:GLOB    matches a function that called the command, with its parameters or without
  ID@file:GLOB  matches the source file of such a function, by its path or relative to the working folder
  ID@A & B      matches if both do

A mistake may violate several ids: the finding has one, and names the others ("also"). A line with
one of the others is used, because what it knows is still there, but only a line with the finding's
own id, or a retired one, makes the finding known: a new mistake must not hide behind an old id."""

import fnmatch
import os
import pathlib

from .call_sites import frames_of_application
from .groups import CARRIERS

AND = " & "  # between conditions
MOST_PARTS = 32  # of the labels around a finding


class BaselineFailure(Exception):
    """A baseline that cannot be read; the text says which line and why."""


class Condition:
    def __init__(self, text):
        self.kind = next((kind for kind in CALLERS if text.startswith(kind)), "")
        self.pattern = text[len(self.kind):]

    def matches(self, finding):
        names = CALLERS[self.kind](finding) if self.kind else names_of(finding)
        return any(fnmatch.fnmatchcase(name, self.pattern) for name in names)


class Entry:
    def __init__(self, text, path, line):
        self.text, self.path, self.line, self.used = text, path, line, 0
        self.id, _, conditions = text.partition("@")
        self.conditions = list(map(Condition, conditions.split(AND))) if conditions else []
        self.carriers = set()  # names that alone made it match: they say where, not what

    @property
    def needs_call_sites(self):
        return any(condition.kind for condition in self.conditions)

    def matches(self, finding):
        return self.id in ids_of(finding) and self.matches_conditions(finding)

    def matches_conditions(self, finding):
        return all(condition.matches(finding) for condition in self.conditions)

    def is_used_by(self, finding):
        return (self.matches(finding) or
                (self.id in finding.get("also", []) and self.matches_conditions(finding)))

    def note_carriers(self, finding):
        """Notes the names of command buffers and the like without which no condition would match."""
        objects = finding.get("Objects", [])
        others = {**finding, "Objects": [item for item in objects if item["type"] not in CARRIERS]}
        if any(condition.matches(others) for condition in self.conditions):
            return
        self.carriers |= {f"{item['type']} \"{item['name']}\"" for item in objects if item.get("name")
                          for condition in self.conditions if condition.matches({"Objects": [item]})}


def ids_of(finding):
    """Returns the id of a finding, and the retired ids of the same rule."""
    return [finding["VUID"], *finding.get("formerly", [])]


def functions_of(finding):
    """Returns the functions of the call site. C++ ones have their parameters, which a line may leave
    out."""
    names = [frame["function"] for frame in frames_of_application(finding)
             if frame.get("function", "??") != "??"]
    return names + [name.partition("(")[0] for name in names if "(" in name]


def files_of(finding):
    files = [frame["file"] for frame in frames_of_application(finding) if frame.get("file")]
    return files + [os.path.relpath(file) for file in files]


CALLERS = {"fn:": functions_of, "file:": files_of}


def names_of(finding):
    """Returns the debug names and labels of a finding, those of command buffers and the like last of the
    objects'. Labels may have :: within, as names of C++ have, so all that may be one label are
    returned."""
    objects = sorted(finding.get("Objects", []), key=lambda item: item["type"] in CARRIERS)
    names = [item["name"] for item in objects if item.get("name")]
    parts = finding.get("DebugRegion", "").split("::")
    if len(parts) > MOST_PARTS:
        parts = parts[:MOST_PARTS]
    return names + ["::".join(parts[first:last]) for first in range(len(parts))
                    for last in range(first + 1, len(parts) + 1) if parts[first:last] != [""]]


def read_baseline(path):
    entries = []
    try:
        lines = pathlib.Path(path).read_text(encoding="utf-8-sig").splitlines()
    except OSError as error:
        raise BaselineFailure(f"{path}: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise BaselineFailure(f"{path}: {error}") from error
    for number, line in enumerate(lines, 1):
        text = line.split("#", 1)[0].strip()
        if not text:
            continue
        name, at, glob = text.partition("@")
        if not name or any(character.isspace() for character in name) or \
                (at and any(part in ("", *CALLERS) for part in glob.split(AND))):
            raise BaselineFailure(f"{path}:{number}: not an id, nor ID@GLOB: {text}")
        entries.append(Entry(text, path, number))
    return entries


def split_known(findings, entries):
    """Returns the new findings and the known ones, and counts the uses of each entry."""
    new, known = [], []
    for finding in findings:
        for entry in entries:
            entry.used += entry.is_used_by(finding)
            if entry.matches(finding):
                entry.note_carriers(finding)
        is_known = any(entry.matches(finding) for entry in entries)
        (known if is_known else new).append(finding)
    return new, known


def quote_glob(name):
    text = "".join(f"[{character}]" if character in "*?[" else character for character in name)
    text = text.replace(AND, " [&] ")
    return f"[{text[0]}]{text[1:]}" if text.startswith(tuple(CALLERS)) else text


def baseline_line(finding):
    """Returns the narrowest line that matches a finding in the next run, too: handles change from run
    to run, debug names and functions do not."""
    names = names_of(finding)
    has_name = any(item.get("name") for item in finding.get("Objects", []))
    has_subject = any(item.get("name") and item["type"] not in CARRIERS
                      for item in finding.get("Objects", []))
    name = names[0] if has_name or len(names) == 1 else ""  # several labels, or one with :: within?
    functions = [] if has_subject else functions_of(finding)
    if functions and is_writable(functions[0]):
        return f"{finding['VUID']}@fn:{quote_glob(functions[0])}"
    return f"{finding['VUID']}@{quote_glob(name)}" if is_writable(name) else finding["VUID"]


def is_writable(name):
    """A # would begin a comment."""
    return name and name.isprintable() and "#" not in name and name == name.strip()


def write_baseline(path, findings):
    lines = sorted({baseline_line(finding) for finding in findings})
    text = "# Known findings of Assay, one a line: an id, or ID@GLOB of a debug name or label.\n"
    pathlib.Path(path).write_text(text + "".join(f"{line}\n" for line in lines), encoding="utf-8")
    return len(lines)

# SPDX-License-Identifier: Apache-2.0
"""Baselines: known findings, one a line.

A line is an id, or ID@GLOB, where GLOB matches the debug name of one of the finding's objects, or
one of its labels. # begins a comment.

A mistake may violate several ids: the finding has one, and names the others ("also"). A line with
one of the others is used, because what it knows is still there, but only a line with the finding's
own id, or a retired one, makes the finding known: a new mistake must not hide behind an old id."""

import fnmatch
import pathlib


MOST_PARTS = 32  # of the labels around a finding


class BaselineFailure(Exception):
    """A baseline that cannot be read; the text says which line and why."""


class Entry:
    def __init__(self, text, path, line):
        self.text, self.path, self.line, self.used = text, path, line, 0
        self.id, _, self.glob = text.partition("@")

    def matches(self, finding):
        return (self.id in [finding["VUID"], *finding.get("formerly", [])] and
                self.matches_names(finding))

    def matches_names(self, finding):
        return not self.glob or any(fnmatch.fnmatchcase(name, self.glob)
                                    for name in names_of(finding))

    def is_used_by(self, finding):
        return (self.matches(finding) or
                (self.id in finding.get("also", []) and self.matches_names(finding)))


def names_of(finding):
    """Returns the debug names and labels of a finding. Labels may have :: within, as names of C++
    have, so all that may be one label are returned."""
    names = [item["name"] for item in finding.get("Objects", []) if item.get("name")]
    parts = finding.get("DebugRegion", "").split("::")
    if len(parts) > MOST_PARTS:
        parts = parts[:MOST_PARTS]
    return names + ["::".join(parts[first:last]) for first in range(len(parts))
                    for last in range(first + 1, len(parts) + 1) if parts[first:last] != [""]]


def read_baseline(path):
    entries = []
    try:
        lines = pathlib.Path(path).read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise BaselineFailure(f"{path}: {error}") from error
    for number, line in enumerate(lines, 1):
        text = line.split("#", 1)[0].strip()
        if not text:
            continue
        name, at, glob = text.partition("@")
        if not name or any(character.isspace() for character in name) or (at and not glob):
            raise BaselineFailure(f"{path}:{number}: not an id, nor ID@GLOB: {text}")
        entries.append(Entry(text, path, number))
    return entries


def split_known(findings, entries):
    """Returns the new findings and the known ones, and counts the uses of each entry."""
    new, known = [], []
    for finding in findings:
        for entry in entries:
            entry.used += entry.is_used_by(finding)
        is_known = any(entry.matches(finding) for entry in entries)
        (known if is_known else new).append(finding)
    return new, known


def quote_glob(name):
    return "".join(f"[{character}]" if character in "*?[" else character for character in name)


def baseline_line(finding):
    """Returns the narrowest line that matches a finding in the next run, too: handles change from run
    to run, debug names do not. A # in a name would begin a comment."""
    names = names_of(finding)
    is_one = any(item.get("name") for item in finding.get("Objects", [])) or len(names) == 1
    name = names[0] if names and is_one else ""  # several labels, or one with :: within?
    if not name or not name.isprintable() or "#" in name or name != name.strip():
        return finding["VUID"]
    return f"{finding['VUID']}@{quote_glob(name)}"


def write_baseline(path, findings):
    lines = sorted({baseline_line(finding) for finding in findings})
    text = "# Known findings of Assay, one a line: an id, or ID@GLOB of a debug name or label.\n"
    pathlib.Path(path).write_text(text + "".join(f"{line}\n" for line in lines), encoding="utf-8")
    return len(lines)

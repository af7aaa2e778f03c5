# SPDX-License-Identifier: Apache-2.0
"""Records: the lines of JSON that the layer writes for each process."""

import json
import pathlib
from collections import Counter


class RecordFailure(Exception):
    """A record that cannot be read; the text says which and why."""


class Record:
    """What one or several processes have reported."""

    def __init__(self):
        self.lines = []
        self.headers, self.devices, self.findings, self.summaries = [], [], [], []
        self.builds = []
        self.incomplete = []  # files whose last line is cut, because the process was killed

    def add(self, line):
        self.lines.append(line)
        kind = line.get("Type")
        lists = {"Header": self.headers, "Device": self.devices, "Finding": self.findings,
                 "Summary": self.summaries}
        lists.get(kind, self.builds).append(line)

    def errors(self):
        return [finding for finding in self.findings if finding["Severity"] == "Error"]

    def warnings(self):
        return [finding for finding in self.findings if finding["Severity"] == "Warning"]

    def held_back(self):
        """Returns how often each id was found beyond what was reported."""
        counts = Counter()
        for summary in self.summaries:
            counts.update(summary.get("HeldBack", {}))
        return counts

    def pids(self):
        return sorted({header["pid"] for header in self.headers})


def read_lines(record, path):
    """Adds a file's lines. A process that is killed may leave half a line at the end."""
    with open(path, encoding="utf-8", errors="replace") as file:
        for number, text in enumerate(file, 1):
            if not text.strip():
                continue
            try:
                line = json.loads(text)
            except ValueError as error:
                if not text.endswith("\n"):
                    record.incomplete.append(str(path))
                    return
                raise RecordFailure(f"{path}:{number}: not a line of JSON: {error}") from error
            if not isinstance(line, dict) or "Type" not in line:
                raise RecordFailure(f"{path}:{number}: not a line of a record")
            record.add(line)


def read_records(paths):
    """Reads files, and all files named *.jsonl in folders and their folders."""
    record = Record()
    for path in map(pathlib.Path, paths):
        try:
            files = sorted(path.rglob("*.jsonl")) if path.is_dir() else [path]
            for file in files:
                read_lines(record, file)
        except OSError as error:
            raise RecordFailure(f"{path}: {error.strerror}") from error
    return record

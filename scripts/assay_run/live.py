# SPDX-License-Identifier: Apache-2.0
"""What the layer reports while the application runs: --live prints it, --stop-at-first acts on it."""

from .baseline import split_known
from .call_sites import resolve_call_sites
from .expectations import split_expected
from .groups import group_findings, identity
from .khronos import Doubles, is_khronos
from .records import is_mistake, parse_line
from .verdict import group_lines


class RecordTail:
    """Reads the lines that are added to the records of a folder."""

    def __init__(self, folder):
        self.folder, self.offsets = folder, {}

    def new_mistakes(self):
        findings = []
        for path in sorted(self.folder.glob("*.jsonl")):
            with open(path, "rb") as file:
                file.seek(self.offsets.get(path, 0))
                text = file.read()
            whole = text.rpartition(b"\n")[0]
            if not whole:
                continue  # the last line may still be written
            self.offsets[path] = self.offsets.get(path, 0) + len(whole) + 1
            lines = map(parse_line, whole.decode("utf-8", "replace").split("\n"))
            findings += [line for line in lines
                         if line and line["Type"] == "Finding" and is_mistake(line)]
        return findings


class Observer:
    """Sees each finding that is neither in the baseline nor announced, soon after it was reported."""

    def __init__(self, records, entries, say=None, stops=False):
        """`say` prints a line; None: nothing is printed. `stops`: the first finding ends the run."""
        self.tail, self.entries, self.say, self.stops = RecordTail(records), entries, say, stops
        self.printed = set()  # identities
        self.doubles, self.waiting = Doubles(), []
        self.is_stopped = False

    def observe(self):
        """Returns whether the application is to be ended."""
        _, findings = split_expected(self.new_findings())
        if any(entry.needs_call_sites for entry in self.entries):
            resolve_call_sites(findings)
        findings, _ = split_known(findings, self.entries)
        for group in group_findings(findings) if self.say else []:
            self.show(group)
        self.is_stopped = self.is_stopped or (self.stops and bool(findings))
        return self.is_stopped

    def new_findings(self):
        """The Khronos layer's come one turn later: Assay may report the same, and is farther from the
        application."""
        found = self.tail.new_mistakes()
        own = [finding for finding in found if not is_khronos(finding)]
        for finding in own:
            self.doubles.note(finding)
        waiting, self.waiting = self.waiting, list(filter(is_khronos, found))
        return own + [finding for finding in waiting if not self.doubles.find(finding)]

    def show(self, group):
        name = identity(group.first)
        if name in self.printed:
            return
        self.printed.add(name)
        resolve_call_sites([group.first])
        group.findings = group.findings[:1]  # how often is in the summary
        for line in group_lines(group):
            self.say(line)

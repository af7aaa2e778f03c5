# SPDX-License-Identifier: Apache-2.0
"""Findings that the application announces: regions of debug labels such as `assay:expect ID`.

The words of such a label are ids, up to a # with a comment. A finding inside the region that has one
of the ids does not count. A region, known by the text of its label, without a finding of one of its
ids is a failure. The record has a line for each region that was opened, even if it has no finding."""

import re

from .baseline import ids_of, names_of

PREFIX = "assay:expect"


class Expectation:
    """An id that regions with one label announce in one process."""

    def __init__(self, label, name):
        self.label, self.id = label, name

    @property
    def text(self):
        return f'{self.id}: expected in the region "{self.label}", but not reported'


def ids_of_label(label):
    """Returns the ids that a label announces; None if it is any other label."""
    words = re.split(r"[\s,]+", label.split("#", 1)[0].strip())
    return words[1:] if words[0] == PREFIX else None


def labels_of(finding):
    """Returns the texts that may be labels around a finding."""
    return names_of({"DebugRegion": finding.get("DebugRegion", "")})


def is_expected(finding):
    """A label of several parts begins like its first part, which has the ids if no comment precedes ::."""
    return any(name in ids_of(finding) for part in finding.get("DebugRegion", "").split("::")
               for name in ids_of_label(part) or ())


def split_expected(findings):
    """Returns the findings that the application has announced, and the others."""
    expected, others = [], []
    for finding in findings:
        (expected if is_expected(finding) else others).append(finding)
    return expected, others


def announced(record):
    """Returns the expectations of each process, by (process, label, id). One without an id is a mistake,
    and stands for itself: no finding has the id that it names."""
    expectations = {}
    for process, line in record.lines:
        if line["Type"] == "Expectation":
            label = str(line.get("label", ""))
            for name in ids_of_label(label) or ["an id"]:
                expectations.setdefault((process, label, name), Expectation(label, name))
    return expectations


def find_absent(record):
    """Returns the expectations without a finding. An id whose messages the limit has held back may have
    been found in any region."""
    expectations = announced(record)
    if not expectations:
        return []
    for process, line in record.lines:
        if line["Type"] == "Finding":
            for label in labels_of(line):
                for name in ids_of(line) + line.get("also", []):
                    expectations.pop((process, label, name), None)
    held_back = record.held_back()
    return [one for one in expectations.values() if not held_back[one.id]]

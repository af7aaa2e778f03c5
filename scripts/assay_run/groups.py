# SPDX-License-Identifier: Apache-2.0
"""Groups of findings that are one mistake: one line of code yields a finding for each frame and each
object that goes through it. So findings of one id from one call site are one mistake. Without call sites,
the command, the labels and the member stand for the place. Advice is about one object each."""

import os
import re

from .properties import RANGES

# These objects say where a mistake was found, not what it is about: each frame has its own.
CARRIERS = ("VkInstance", "VkDevice", "VkQueue", "VkCommandBuffer")
# What differs between findings of one kind: handles with the debug names of their objects, numbers, and
# the plural that goes with a number.
NAMED_HANDLES = re.compile(r"\b0x[0-9a-f]+(\[\"[^\"]*\"\])?")
QUOTED = re.compile(r"\"[^\"]*\"")
NUMBERS = re.compile(r"[-+]?\b\d[\d,.]*(e[-+]?\d+)?\b")
PLURALS = re.compile(r"# (\w+?)e?s\b")
MORE = re.compile(r" \(and \d+ more \w+\)")  # of the same kind in a build: each frame may have other ones
INDICES = re.compile(r"\[\d+\]")
DIGITS = re.compile(r"\d+")
NAMES_SHOWN = 3
VARIANTS_SHOWN = 2


def skeleton(message):
    """Returns the message without what differs from frame to frame, and from object to object."""
    text = QUOTED.sub("", NAMED_HANDLES.sub("#", MORE.sub("", message)))
    return PLURALS.sub(r"# \1", NUMBERS.sub("#", text))


def subjects(finding):
    """Returns the objects that a finding is about."""
    return [item for item in finding.get("Objects", []) if item["type"] not in CARRIERS]


def is_of_one_object(finding):
    """Returns whether a finding is advice, or a message without a command."""
    return finding["VUID"].startswith("ASSAY-advice-") or not finding.get("Function")


def kind(finding):
    """Returns what findings of one mistake have in common from run to run, but for their place in the
    source."""
    if is_of_one_object(finding):
        names = tuple((item["type"], item.get("name") or "") for item in subjects(finding))
        return finding["VUID"], finding["Severity"], names
    return finding["VUID"], finding["Severity"], finding["Function"]


def place_in_command(finding):
    """Returns where a mistake without a call site is: the labels, without numbers of frames, and the
    member."""
    return (DIGITS.sub("", finding.get("DebugRegion", "")),
            INDICES.sub("[]", finding.get("Location", "")))


def identity(finding):
    """Returns what findings of one mistake have in common in a run."""
    site = tuple((os.path.basename(frame["module"]), frame["offset"])
                 for frame in finding.get("call_site", []))
    if is_of_one_object(finding):
        return kind(finding), site, skeleton(finding["MainMessage"]), finding.get("Layer")
    return kind(finding), site or place_in_command(finding), finding.get("Layer")


class Group:
    """Findings with one identity, in the order in which they were reported."""

    def __init__(self):
        self.findings = []

    @property
    def first(self):
        return self.findings[0]

    @property
    def count(self):
        return len(self.findings)

    @property
    def layers(self):
        """Returns which layers have reported it, if it is not Assay alone."""
        if self.first.get("Layer"):
            return f"{self.first['Layer']} layer"
        return "both layers" if any(one.get("LayerToo") for one in self.findings) else ""

    @property
    def title(self):
        return self.first["VUID"] + (f" ({self.layers})" if self.layers else "")

    def ranges(self):
        """Returns the first and the last submission, frame and so on, of those that the findings have."""
        numbers = {key: [finding[key] for finding in self.findings if key in finding] for key in RANGES}
        return {key: (min(found), max(found)) for key, found in numbers.items() if found}

    def variants(self):
        """Returns the first finding of each kind of message."""
        firsts = {}
        for finding in self.findings:
            firsts.setdefault(skeleton(finding["MainMessage"]), finding)
        return list(firsts.values())

    def objects(self):
        """Returns the debug names, or else the handles, of the objects that the findings are about: of each
        finding the first one."""
        firsts = [items[0] for items in map(subjects, self.findings) if items]
        return list(dict.fromkeys(item.get("name") or item["handle"] for item in firsts))

    def command_buffers(self):
        """Returns the debug names of the command buffers, and the handles of those that have none."""
        return list(dict.fromkeys(
            item.get("name") or item["handle"] for finding in self.findings
            for item in finding.get("Objects", []) if item["type"] == "VkCommandBuffer"))


def group_findings(findings):
    groups = {}
    for finding in findings:
        groups.setdefault(identity(finding), Group()).findings.append(finding)
    return list(groups.values())


def first_names(names):
    others = len(names) - NAMES_SHOWN
    return ", ".join(names[:NAMES_SHOWN]) + (f" and {others:,} more" if others > 0 else "")


def repetition_lines(group):
    """Returns lines that say how often a mistake was reported, where, and of which objects; none for a
    single finding."""
    if group.count == 1:
        return []
    text = f"{group.count:,} times"
    for key, (first, last) in group.ranges().items():
        text += ", " + RANGES[key].format(f"{first:,}", f"{last:,}") if first != last else ""
    buffers = group.command_buffers()
    if len(buffers) > 1:
        text += f", in {len(buffers):,} command buffers: {first_names(buffers)}"
    objects = group.objects()
    lines = [text, f"{len(objects):,} objects: {first_names(objects)}"] if len(objects) > 1 else [text]
    variants = group.variants()[1:]
    lines += [f"also: {' '.join(one['MainMessage'].split())}" for one in variants[:VARIANTS_SHOWN]]
    if len(variants) > VARIANTS_SHOWN:
        others = len(variants) - VARIANTS_SHOWN
        lines.append(f"and {others:,} other message{'s' if others > 1 else ''} of this id")
    return lines


def range_data(group):
    return {f"{name}_{key}": number for key, numbers in group.ranges().items()
            for name, number in zip(("first", "last"), numbers)}


def group_data(group):
    """Returns the repetition of a group for reports in JSON."""
    return {"VUID": group.first["VUID"], "count": group.count,
            "command_buffers": group.command_buffers(), "objects": group.objects(), **range_data(group)}

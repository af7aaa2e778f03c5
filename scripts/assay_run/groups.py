# SPDX-License-Identifier: Apache-2.0
"""Groups of findings that are one mistake: a mistake in a frame's code yields a finding each frame."""

import os
import re

# These objects say where a mistake was found, not what it is about: each frame has its own.
CARRIERS = ("VkInstance", "VkDevice", "VkQueue", "VkCommandBuffer")
# What differs from frame to frame in a message: handles and addresses with the debug names of carriers,
# and numbers of submissions. Shorter hexadecimal numbers are flags.
CARRIER_NAMES = re.compile(r"\b(%s) 0x[0-9a-f]+(\[\"[^\"]*\"\])?" % "|".join(CARRIERS))
HANDLES = re.compile(r"\b0x[0-9a-f]{5,}\b")
NUMBERS = re.compile(r"\b(submissions?|age) [\d,]+")
MORE = re.compile(r" \(and \d+ more \w+\)")  # of the same kind in a build: each frame may have other ones
NAMES_SHOWN = 3


def skeleton(message):
    """Returns the message without what differs from frame to frame."""
    text = CARRIER_NAMES.sub(r"\1", message)
    return NUMBERS.sub(r"\1", HANDLES.sub("0x", MORE.sub("", text)))


def subject(finding):
    """Returns what a finding is about: id, member, and the objects by their debug names, else the labels.
    Applications put numbers of frames into labels, so labels do not count beside a name."""
    subjects = tuple((item["type"], item.get("name") or "") for item in finding.get("Objects", [])
                     if item["type"] not in CARRIERS)
    label = "" if any(name for _, name in subjects) else finding.get("DebugRegion", "")
    return (finding["VUID"], finding["Severity"], finding.get("Function", ""),
            finding.get("Location", ""), label, subjects)


def identity(finding):
    """Returns what findings of one mistake have in common in a run."""
    site = tuple((os.path.basename(frame["module"]), frame["offset"])
                 for frame in finding.get("call_site", []))
    return subject(finding), site, skeleton(finding["MainMessage"]), finding.get("Layer")


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

    def submissions(self):
        """Returns the numbers of the first and the last submission; None if no finding has one."""
        numbers = [finding["submission"] for finding in self.findings if "submission" in finding]
        return (min(numbers), max(numbers)) if numbers else None

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


def repetition_lines(group):
    """Returns a line that says how often a finding was reported, and where; none for a single one."""
    if group.count == 1:
        return []
    text = f"{group.count:,} times"
    submissions = group.submissions()
    if submissions and submissions[0] != submissions[1]:
        text += f", from submission {submissions[0]:,} to submission {submissions[1]:,}"
    buffers = group.command_buffers()
    if len(buffers) > 1:
        others = len(buffers) - NAMES_SHOWN
        text += f", in {len(buffers):,} command buffers: " + ", ".join(buffers[:NAMES_SHOWN])
        text += f" and {others:,} more" if others > 0 else ""
    return [text]


def group_data(group):
    """Returns the repetition of a group for reports in JSON."""
    submissions = group.submissions()
    data = {"VUID": group.first["VUID"], "count": group.count,
            "command_buffers": group.command_buffers()}
    if submissions:
        data["first_submission"], data["last_submission"] = submissions
    return data

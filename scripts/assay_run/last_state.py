# SPDX-License-Identifier: Apache-2.0
"""What the record of setting record_builds says of a process that ended without vkDestroyInstance: the layer
had no chance to list its advice."""

from collections import Counter

ALLOW_COMPACTION = 0x2
LARGEST_SHOWN = 3
MIB = 1 << 20


class LastState:
    """The structures that are alive after all lines of a process."""

    def __init__(self):
        self.submissions, self.structures = 0, {}

    def add(self, line):
        kind, dst = line["Type"], (line.get("device"), line.get("dst"))
        if kind == "Submission":
            self.submissions += 1
        elif kind == "Destroyed":
            self.structures.pop(dst, None)
        elif kind in ("Build", "Copy") and line.get("dst"):
            self.structures.setdefault(dst, {"compacted": False}).update(line)
            src = self.structures.get((line.get("device"), line.get("src")))
            if src and kind == "Copy" and line.get("mode") == "compact":
                src["compacted"] = True

    def lines(self, pid):
        alive = sorted((one for one in self.structures.values() if one.get("type") != "micromap"),
                       key=lambda one: -one.get("size", 0))
        if not alive:
            return []
        text = (f"process {pid} ended without vkDestroyInstance, so the list of advice is missing: after "
                f"{self.submissions:,} submission{'s' * (self.submissions != 1)} {describe(alive)} alive; the largest: "
                f"{', '.join(map(name_of, alive[:LARGEST_SHOWN]))}")
        idle = [one for one in alive if int(one.get("flags", "0x0"), 16) & ALLOW_COMPACTION
                and not one["compacted"]]
        if idle:
            text += f"; {describe(idle)} built with ALLOW_COMPACTION and never compacted"
        return [text]


def describe(structures):
    size = sum(one.get("size", 0) for one in structures) / MIB
    count = len(structures)
    return f"{count:,} acceleration structure{'s' if count > 1 else ''} ({size:,.1f} MiB) " + \
        ("were" if count > 1 else "was")


def name_of(structure):
    return structure.get("dst_name") or structure["dst"]


def last_state_lines(record):
    """Returns a line for each process that has recorded builds, and has not destroyed its last instance."""
    ends, states = Counter(), {}
    for process, line in record.lines:
        ends[process] += {"Header": 1, "Summary": -1}.get(line["Type"], 0)
        states.setdefault(process, LastState()).add(line)
    pids = {number: pid for (_, pid), number in record.processes.items()}
    return [text for process, state in states.items() if process is not None and ends[process] > 0
            for text in state.lines(pids[process])]

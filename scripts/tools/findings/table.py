# SPDX-License-Identifier: Apache-2.0
"""Counts verdicts by what they are about, and prints them as a table for docs/khronos.md."""

import collections
import re

HOST_DATA = ("calls/data", "calls/data_extensions")
EXTENSIONS = ("calls/micromap", "calls/life_micromap", "calls/extensions", "execution/extensions")
OVERLAPS = ("calls/overlap",)
# Programs about objects that were destroyed or lacked memory when a batch executed, or were too small.
OBJECTS = ("execution/destroyed", "execution/size", "execution/sparse", "execution/unbuilt")
# Pointers and handles that lead to no memory, or to other memory than they should; endless lists.
NOWHERE = re.compile(
    r"^calls/call: (infos|ranges|counts|geometr)\w*_(null|small|too_near)|unreadable|end_too_early|ends_too_early|off_the_page|one_short|cut_short|"
    r"over_edge|usages_too_many|chain_loop|command_buffer_is_|device_is_|any_limit|low_address|"
    r"pointers_to_nowhere|arrays_none|no_structure")

PARAMETERS, OVERLAP, UPDATES = "parameters and state", "overlaps", "updates in the order of execution"
OBJECT = "destroyed objects, unbound memory, sizes, in the order of execution"
DEVICE_CONTENT, HOST_CONTENT = "data of device builds", "data of host builds"
HOST, INDIRECT, NV = "host builds", "indirect builds", "`VK_NV_ray_tracing`"
EXTENSION = "micromaps, motion, spheres, dense geometry"
CLUSTER = "builds of clusters and of partitioned structures"
LIFE = "commands that create, copy, query, bind and destroy"
UNREADABLE = "pointers to unreadable memory"
GROUPS = (PARAMETERS, OVERLAP, UPDATES, OBJECT, DEVICE_CONTENT, HOST_CONTENT, HOST, INDIRECT, NV, EXTENSION,
          CLUSTER, LIFE, UNREADABLE)


def group_of(program, name):
    """The row of the table that a play belongs to."""
    list_name = name.split(": ")[0]
    command = name.rsplit("/", 1)[-1].split("@")[0].split(" ")[0]
    groups = (
        (program == "content", DEVICE_CONTENT),
        (NOWHERE.search(name), UNREADABLE),
        (list_name in HOST_DATA, HOST_CONTENT),
        (re.match("vk.*(Cluster|Partitioned)", command), CLUSTER),
        (list_name.startswith(EXTENSIONS) or re.match("vk.*Micromap", command), EXTENSION),
        (command.startswith("vk"), LIFE),
        ("nv" in (command, list_name.split("/")[-1]), NV),
        (list_name.startswith(OBJECTS), OBJECT),
        (program == "execution", UPDATES),
        (list_name in OVERLAPS, OVERLAP),
        (command == "host", HOST),
        (command == "indirect", INDIRECT),
    )
    return next((group for belongs, group in groups if belongs), PARAMETERS)


class Row:
    def __init__(self):
        self.outcomes = collections.Counter()  # of mistakes
        self.counts = collections.Counter()
        self.alarms = collections.Counter()    # id -> valid plays

    def count(self, verdict):
        if verdict.kind == "mistake":
            self.outcomes[verdict.outcome] += 1
            self.counts["mistakes"] += 1
            self.counts["found by Assay"] += verdict.assay
        self.counts["valid"] += verdict.is_valid_call
        self.counts["alarms"] += bool(verdict.alarms)
        self.counts["crashes"] += verdict.crashed
        self.counts["alarms of Assay"] += verdict.assay_alarmed
        self.alarms.update(verdict.alarms)

    def add(self, other):
        self.outcomes += other.outcomes
        self.counts += other.counts
        self.alarms += other.alarms

    def print(self, name):
        mistakes = self.counts["mistakes"]

        def share(count):
            return f"{count:,} ({100 * count / mistakes:.0f} %)" if mistakes else "-"

        crashes = self.outcomes["crashed"] + self.outcomes["hung"]
        cells = (name, f"{mistakes:,}", share(self.counts["found by Assay"]),
                 share(self.outcomes["found"]), f"{self.outcomes['another id']:,}", f"{crashes:,}",
                 f"{self.counts['valid']:,}", f"{self.counts['alarms of Assay']:,}",
                 f"{self.counts['alarms']:,}")
        print("| " + " | ".join(cells) + " |")


class Table:
    def __init__(self):
        self.rows = {group: Row() for group in GROUPS}
        self.left_out = collections.Counter()

    def count(self, program, name, verdict):
        if verdict.kind == "left out":
            self.left_out[verdict.reason] += 1
        else:
            self.rows[group_of(program, name)].count(verdict)

    def print(self):
        """Returns the sum of all rows."""
        total = Row()
        print("| mistakes in | planted | found by Assay | found by Khronos | with another id "
              "| crashes | valid calls | false alarms: Assay | Khronos |")
        print("| --- " * 9 + "|")
        for name, row in self.rows.items():
            if row.counts["valid"] or row.counts["mistakes"]:
                row.print(name)
            total.add(row)
        total.print("all")
        print(f"\nOn {total.counts['crashes']} valid calls the Khronos layer crashed.")
        print("\nIds of the Khronos layer's false alarms, and the number of valid calls with each:")
        for name, count in total.alarms.most_common():
            print(f"  {count:6,}  {name}")
        return total

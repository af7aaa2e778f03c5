# SPDX-License-Identifier: Apache-2.0
"""The page of --html: one file, made from the record alone."""

import datetime
import html
import json
import pathlib
import re

from .call_sites import frames_of_application, place_of
from .groups import Group, identity, repetition_lines, subjects
from .properties import RANGES
from .scene import places_in_scene, writes_by_place
from .verdict import describe_exit, mistake_lines

HERE = pathlib.Path(__file__).resolve().parent

# The members of the lines of record_builds that the page shows: words, then numbers. The record's lines
# name each member; for thousands of builds the names would take most of the page.
WORDS = ("Type", "mode", "type", "queue", "dst", "dst_name", "src", "command_buffer",
         "command_buffer_name", "device", "memory", "flags", "references")
NUMBERS = (*RANGES, "build", "primitives", "size", "scratch_size", "compacted_size",
           "memory_offset", "referring")
SCRIPTS = ("builds.js", "structures.js", "page.js")
SCENE_SCRIPTS = ("scene.js", "scene_list.js")
MISSING = -1
MOST_ROWS = 100_000  # about 8 MB
RECORDED = ("Submission", "Build", "Copy", "CompactedSize", "Destroyed", "Instances")
REFERENCES_SHOWN = 8
OTHER_OBJECTS = 1000


class Clock:
    """Milliseconds since the first line of a process."""

    def __init__(self, lines):
        self.starts = {}
        for process, line in lines:
            if process not in self.starts and parse_time(line):
                self.starts[process] = parse_time(line)

    def at(self, process, line):
        """Returns None if the line has no time, or no process."""
        time = parse_time(line)
        if process is None or not time:
            return None
        return max(0, round((time - self.starts[process]).total_seconds() * 1000))


def parse_time(line):
    try:
        return datetime.datetime.strptime(str(line.get("time")), "%Y-%m-%dT%H:%M:%S.%fZ")
    except ValueError:
        return None


def place_data(finding, process, recorded, clock):
    """`recorded` has the submissions of findings that the record does not tie to one."""
    place = recorded.get(id(finding))
    queue, submission = place or (finding.get("queue"), finding.get("submission"))
    return {**{key: finding.get(key) for key in RANGES}, "queue": queue, "submission": submission,
            "isRecorded": bool(place), "process": process, "ms": clock.at(process, finding)}


def object_data(item):
    return {"type": item["type"], "handle": item["handle"], "name": item.get("name", "")}


def other_objects(group):
    """Returns the objects that only later findings of a group name, for the filters."""
    items = {(item["type"], item["handle"], item.get("name", "")): item
             for finding in group.findings for item in subjects(finding)}
    for item in group.first.get("Objects", []):
        items.pop((item["type"], item["handle"], item.get("name", "")), None)
    return list(map(object_data, list(items.values())[:OTHER_OBJECTS]))


def finding_data(group, processes, recorded, clock, writes):
    """A mistake that was reported several times is one finding with several places. `writes`: those that the
    3D view shows."""
    finding = group.first
    reports = [place_data(one, processes[id(one)], recorded, clock) for one in group.findings]
    shown = places_in_scene(group.findings, reports, writes, command_buffer_of) if writes else []
    return {"id": finding["VUID"], "severity": finding["Severity"],
            "message": finding["MainMessage"], "layers": group.layers, "spec": finding.get("SpecText", ""),
            "url": finding.get("SpecUrl", ""), "labels": finding.get("DebugRegion", ""),
            "also": finding.get("also", []),
            "objects": list(map(object_data, finding.get("Objects", []))),
            "otherObjects": other_objects(group),
            "place": list(map(place_of, frames_of_application(finding))),
            "repetition": repetition_lines(group),
            "reports": reports, **({"shown": shown} if shown else {})}


def with_references(line):
    """Adds what the instances refer to, as text, and how many do, if that is known."""
    structures = line.get("structures", [])
    texts = [f"{one['instances']:,} × {'“' + one['name'] + '”' if one.get('name') else one['handle']}"
             for one in structures[:REFERENCES_SHOWN]]
    total = line.get("structure_count", 0)
    if total > REFERENCES_SHOWN:
        texts.append(f"{total - REFERENCES_SHOWN:,} structures more")
    known = {"referring": sum(one["instances"] for one in structures)} if total == len(structures) else {}
    return {**line, "references": ", ".join(texts), **known}


def build_data(lines, clock):
    """Returns the distinct words once, and each line as a list: the places of its words, and numbers."""
    words, rows, left_out = {}, [], 0
    for process, line in lines:
        if line["Type"] not in RECORDED:
            continue
        if len(rows) == MOST_ROWS:
            left_out += 1
            continue
        if line["Type"] == "Instances":
            line = with_references(line)
        row = [words.setdefault(str(line[member]), len(words)) if member in line else MISSING
               for member in WORDS]
        time = clock.at(process, line)
        rows.append(row + [line.get(member, MISSING) for member in NUMBERS] +
                    [process, MISSING if time is None else time])
    return {"words": list(words), "wordMembers": WORDS, "numberMembers": [*NUMBERS, "process", "ms"],
            "rows": rows, "leftOut": left_out}


def command_buffer_of(finding):
    """The first that a finding names is the one that it arose in."""
    return next((item["handle"] for item in finding.get("Objects", [])
                 if item["type"] == "VkCommandBuffer"), None)


def submissions_of_findings(lines):
    """A finding that arises while a command buffer is recorded has no submission: returns the first that
    executes the command buffer afterwards, as (queue, submission) by the finding's identity."""
    waiting, places = {}, {}
    for process, line in lines:
        key = process, line.get("device")
        if line["Type"] == "Finding" and "submission" not in line and command_buffer_of(line):
            waiting.setdefault((*key, command_buffer_of(line)), []).append(line)
        if line["Type"] not in RECORDED or "submission" not in line:
            continue
        for handle in [line.get("command_buffer"), *line.get("command_buffers", [])]:
            for finding in waiting.pop((*key, handle), []):
                places[id(finding)] = line["queue"], line["submission"]
    return places


def advice_groups(record, processes):
    """Advice is about one structure each, and handles tell those without debug names apart."""
    groups = {}
    for finding in record.advice():
        unnamed = [item["handle"] for item in finding.get("Objects", []) if not item.get("name")]
        key = identity(finding), (processes[id(finding)], *unnamed) if unnamed else ()
        groups.setdefault(key, Group()).findings.append(finding)
    return groups.values()


def describe_driver(device):
    return " ".join(filter(None, (device.get("Driver"), device.get("DriverInfo"))))


def page_data(verdict, command, scene):
    record = verdict.record
    header = record.headers[0] if record.headers else {}
    processes = {id(line): process for process, line in record.lines}
    recorded = submissions_of_findings(record.lines)
    clock = Clock(record.lines)
    writes = writes_by_place(scene["views"]) if scene else {}

    def show(groups):
        return [finding_data(group, processes, recorded, clock, writes) for group in groups]

    return {"command": " ".join(command) if command else "merged records",
            "mistakes": mistake_lines(verdict) + [one.text for one in verdict.absent] +
                        ([describe_exit(verdict.status)] if verdict.status else []),
            "processes": [str(pid) for _, pid in record.processes],
            "axis": list(RANGES),
            "version": header.get("LayerVersion", ""), "settings": header.get("Settings", {}),
            "drivers": sorted({describe_driver(device) for device in record.devices}),
            "new": show(verdict.new_groups),
            "known": show(verdict.known_groups + verdict.expected_groups),
            "advice": show(advice_groups(record, processes)),
            "warnings": list(dict.fromkeys(line["MainMessage"] for line in record.warnings())),
            "heldBack": dict(record.held_back()),
            "unchecked": list(dict.fromkeys(reason for summary in record.summaries
                                            for reason in summary.get("Unchecked", []))),
            "unused": [f"{entry.text} ({entry.path}:{entry.line})"
                       for entry in verdict.unused_entries],
            "builds": build_data(record.lines, clock), **({"scene": scene} if scene else {})}


def read_part(name):
    return (HERE / "page_parts" / name).read_text(encoding="utf-8")


def write_page(path, verdict, command, scene=None):
    """`scene` has what the 3D view shows; None: the page has none."""
    view = scene and scene.data(list(verdict.record.processes))
    data = json.dumps(page_data(verdict, command, view), ensure_ascii=False, separators=(",", ":"))
    parts = {"title": html.escape(f"Assay: {' '.join(command) if command else 'merged records'}"),
             "style": read_part("page.css"),
             "scene": read_part("scene.html") if view else "",
             "three": scene.script() if view and view["views"] else "",
             "script": "\n".join(map(read_part, (*SCENE_SCRIPTS, *SCRIPTS) if view else SCRIPTS)),
             # Nothing within a script may look like its end.
             "data": data.replace("<", "\\u003c").replace("\u2028", "\\u2028")}
    text = re.sub(r"\{\{(\w+)\}\}", lambda match: parts[match.group(1)], read_part("page.html"))
    pathlib.Path(path).write_text(text, encoding="utf-8")

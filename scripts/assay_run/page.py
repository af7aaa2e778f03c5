# SPDX-License-Identifier: Apache-2.0
"""The page of --html: one file, made from the record alone."""

import html
import json
import pathlib
import re

from .call_sites import frames_of_application, place_of
from .verdict import describe_exit, mistake_lines

HERE = pathlib.Path(__file__).resolve().parent

# The columns of a build in the page's data. The record's lines name each member; for thousands of
# builds the names would take most of the page.
BUILD_MEMBERS = ("Type", "queue", "submission", "mode", "type", "dst", "dst_name", "src", "primitives",
                 "size", "compacted_size", "command_buffer", "build", "device", "memory", "pid")


def finding_data(finding):
    return {"id": finding["VUID"], "severity": finding["Severity"],
            "message": finding["MainMessage"], "spec": finding.get("SpecText", ""),
            "url": finding.get("SpecUrl", ""), "labels": finding.get("DebugRegion", ""),
            "objects": [f"{item['type']} {item['handle']}" +
                        (f" “{item['name']}”" if item.get("name") else "")
                        for item in finding.get("Objects", [])],
            "place": list(map(place_of, frames_of_application(finding))),
            "queue": finding.get("queue"), "submission": finding.get("submission"),
            "pid": finding.get("pid")}


def build_data(builds):
    """Returns the distinct words once, and each build as a list of numbers and places of words."""
    words, places, rows = [], {}, []
    for build in builds:
        row = []
        for member in BUILD_MEMBERS:
            value = build.get(member)
            if isinstance(value, str):
                if value not in places:
                    places[value] = len(words)
                    words.append(value)
                value = [places[value]]
            row.append(value)
        rows.append(row)
    return {"members": BUILD_MEMBERS, "words": words, "rows": rows}


def describe_driver(device):
    return " ".join(filter(None, (device.get("Driver"), device.get("DriverInfo"))))


def page_data(verdict, command):
    record = verdict.record
    header = record.headers[0] if record.headers else {}
    return {"command": " ".join(command) if command else "merged records",
            "mistakes": mistake_lines(verdict) +
                        ([describe_exit(verdict.status)] if verdict.status else []),
            "processes": len(record.processes),
            "version": header.get("LayerVersion", ""), "settings": header.get("Settings", {}),
            "drivers": sorted({describe_driver(device) for device in record.devices}),
            "new": list(map(finding_data, verdict.new)),
            "known": list(map(finding_data, verdict.known)),
            "warnings": list(dict.fromkeys(line["MainMessage"] for line in record.warnings())),
            "heldBack": dict(record.held_back()),
            "unchecked": list(dict.fromkeys(reason for summary in record.summaries
                                            for reason in summary.get("Unchecked", []))),
            "unused": [f"{entry.text} ({entry.path}:{entry.line})"
                       for entry in verdict.unused_entries],
            "builds": build_data(record.builds)}


def write_page(path, verdict, command):
    data = json.dumps(page_data(verdict, command), ensure_ascii=False, separators=(",", ":"))
    parts = {"title": html.escape(f"Assay: {' '.join(command) if command else 'merged records'}"),
             "style": (HERE / "page.css").read_text(encoding="utf-8"),
             "script": (HERE / "page.js").read_text(encoding="utf-8"),
             # Nothing within a script may look like its end.
             "data": data.replace("<", "\\u003c").replace("\u2028", "\\u2028")}
    template = (HERE / "page.html").read_text(encoding="utf-8")
    text = re.sub(r"\{\{(\w+)\}\}", lambda match: parts[match.group(1)], template)
    pathlib.Path(path).write_text(text, encoding="utf-8")

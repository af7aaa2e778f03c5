# SPDX-License-Identifier: Apache-2.0
"""Reports for other programs: JUnit, SARIF, JSON and GitHub's annotations."""

import hashlib
import json
import os
import pathlib
import re
import shlex
import urllib.parse
import xml.etree.ElementTree as ElementTree

from .call_sites import first_place, frames_of_application, place_of
from .groups import group_data, group_findings, kind, place_in_command, range_data, repetition_lines
from .verdict import call_site_lines, command_lines, describe_exit, mistake_lines

# XML 1.0 allows no other control characters, escaped or not.
NOT_XML = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def xml_text(text):
    return NOT_XML.sub("\N{REPLACEMENT CHARACTER}", text)


def full_text(group):
    """Returns the message with the specification's sentence, the place in the source, and how often the
    mistake was reported."""
    finding = group.first
    text = marked_message(group)
    if finding.get("SpecText"):
        text += f"\nThe Vulkan spec states: {finding['SpecText']}"
    if finding.get("SpecUrl"):
        text += f" ({finding['SpecUrl']})"
    return "\n".join([text, *command_lines(finding), *call_site_lines(finding), *repetition_lines(group)])


def marked_message(group):
    """Returns the message, and says if the other layer has reported it."""
    return f"{group.layers}: {group.first['MainMessage']}" if group.first.get("Layer") else \
        group.first["MainMessage"]


def by_id(groups):
    ids = {}
    for group in groups:
        ids.setdefault(group.first["VUID"], []).append(group)
    return ids


def junit_cases(verdict):
    """Returns the test cases as (name, kind, attributes, text); kind is None if it passed.

    One is for the run as a whole, so that a report is never empty; then one for each id."""
    new, known = by_id(verdict.new_groups), by_id(verdict.known_groups)
    mistakes = mistake_lines(verdict)
    if verdict.status:
        mistakes.append(describe_exit(verdict.status))
    yield ("the run", "error" if mistakes else None,
           {"type": "run", "message": "; ".join(mistakes)}, "\n".join(mistakes))
    for name, groups in sorted(new.items()):
        yield (name, "failure",
               {"type": groups[0].first["Severity"], "message": marked_message(groups[0])},
               "\n\n".join(map(full_text, groups)))
    for name, groups in sorted(known.items()):
        if name not in new:
            count = sum(group.count for group in groups)
            yield name, "skipped", {"message": f"in the baseline, {count} times"}, ""
    for name, groups in by_id(group_findings(verdict.record.advice())).items():
        text = "; ".join(group.first["MainMessage"] for group in groups)
        yield name, "skipped", {"message": f"advice: {text}"}, ""
    for name, groups in sorted(by_id(verdict.expected_groups).items()):
        yield f"expected: {name}", None, {}, ""
    for one in verdict.absent:
        yield (f"expected: {one.id}", "failure", {"type": "expectation", "message": one.text}, "")
    if verdict.is_strict:
        for entry in verdict.unused_entries:
            yield (f"baseline line {entry.line}", "failure",
                   {"type": "baseline", "message": "matches no finding any more"}, entry.text)


def write_junit(path, verdict, name):
    cases = list(junit_cases(verdict))
    kinds = [kind for _, kind, _, _ in cases]
    root = ElementTree.Element("testsuites")
    suite = ElementTree.SubElement(
        root, "testsuite", name=xml_text(f"assay: {name}"), tests=str(len(cases)),
        failures=str(kinds.count("failure")), errors=str(kinds.count("error")),
        skipped=str(kinds.count("skipped")), time="0")
    for title, kind, attributes, text in cases:
        case = ElementTree.SubElement(suite, "testcase", classname="assay", name=xml_text(title),
                                      time="0")
        if kind:
            attributes = {key: xml_text(value) for key, value in attributes.items()}
            ElementTree.SubElement(case, kind, attributes).text = xml_text(text) or None
    ElementTree.indent(root)
    ElementTree.ElementTree(root).write(path, encoding="utf-8", xml_declaration=True)


def artifact_location(path):
    """Paths are relative to the repository if they are in it, so that annotations find them."""
    relative = os.path.relpath(path)
    if relative.startswith("..") and os.path.isabs(path):
        return {"uri": pathlib.Path(path).as_uri()}
    return {"uri": urllib.parse.quote(relative.replace(os.sep, "/")), "uriBaseId": "%SRCROOT%"}


def sarif_location(finding, application):
    """Without a known line, the location is the application: code scanning wants a location."""
    place = first_place(finding)
    location = {"physicalLocation": {
        "artifactLocation": artifact_location(place["file"] if place else application),
        "region": {"startLine": max(1, place["line"]) if place else 1}}}
    names = [{"name": item.get("name") or item["handle"], "kind": item["type"]}
             for item in finding.get("Objects", [])]
    if names:
        location["logicalLocations"] = names
    return location


def sarif_stack(finding):
    """All callers, those without a known line, too."""
    frames = []
    for frame in frames_of_application(finding):
        location = {"message": {"text": place_of(frame)}}
        if frame.get("file"):
            location["physicalLocation"] = {"artifactLocation": artifact_location(frame["file"]),
                                            "region": {"startLine": frame["line"]}}
        frames.append({"location": location, "module": frame["module"]})
    return {"message": {"text": "The call that recorded the build"}, "frames": frames}


def fingerprint(finding):
    """Stays the same from run to run, also if the application was built again: handles, addresses and
    offsets are left out."""
    place = first_place(finding)
    parts = kind(finding), ((os.path.basename(place["file"]), place["function"]) if place
                            else place_in_command(finding))
    return hashlib.sha256(repr(parts).encode("utf-8", "backslashreplace")).hexdigest()


def sarif_result(group, application, suppression=None):
    """`suppression` is its kind and the reason, if the finding does not count."""
    finding = group.first
    result = {"ruleId": finding["VUID"],
              "level": {"Error": "error", "Warning": "warning"}.get(finding["Severity"], "note"),
              "message": {"text": "\n".join([marked_message(group), *repetition_lines(group)])},
              "partialFingerprints": {"assay/v3": fingerprint(finding)},
              "occurrenceCount": group.count,
              "locations": [sarif_location(finding, application)]}
    if finding.get("call_site"):
        result["stacks"] = [sarif_stack(finding)]
    properties = ({"reportedBy": group.layers} if group.layers else {}) | range_data(group)
    if properties:
        result["properties"] = properties
    if suppression:
        kind, reason = suppression
        result["suppressions"] = [{"kind": kind, "justification": reason}]
    return result


def sarif_rule(group):
    finding = group.first
    rule = {"id": finding["VUID"]}
    if finding.get("SpecText"):
        rule["fullDescription"] = {"text": finding["SpecText"]}
    if finding.get("SpecUrl"):
        rule["helpUri"] = finding["SpecUrl"]
    return rule


def write_sarif(path, verdict, command):
    header = verdict.record.headers[0] if verdict.record.headers else {}
    groups = verdict.new_groups + verdict.known_groups + verdict.expected_groups
    driver = {"name": "Assay", "rules": [sarif_rule(alike[0]) for alike in by_id(groups).values()]}
    if header.get("LayerVersion"):
        driver["version"] = header["LayerVersion"]
    invocation = {"executionSuccessful": verdict.is_loaded and verdict.is_whole and
                  verdict.status == 0}
    notes = mistake_lines(verdict) + [one.text for one in verdict.absent]
    if notes:
        invocation["toolExecutionNotifications"] = [{"level": "error", "message": {"text": note}}
                                                    for note in notes]
    if command:
        invocation["commandLine"] = shlex.join(command)
    application = (command or ["merged records"])[0]
    run = {"tool": {"driver": driver},
           "invocations": [invocation],
           "results": [sarif_result(group, application) for group in verdict.new_groups] +
                      [sarif_result(group, application, ("external", "in the baseline"))
                       for group in verdict.known_groups] +
                      [sarif_result(group, application, ("inSource", "announced by a label"))
                       for group in verdict.expected_groups]}
    write_json_file(path, {"version": "2.1.0",
                           "$schema": "https://json.schemastore.org/sarif-2.1.0.json",
                           "runs": [run]})


def write_json(path, verdict, status):
    """The record in one object, with the verdict."""
    write_json_file(path, {"loaded": verdict.is_loaded, "whole": verdict.is_whole,
                           "status": status, "application_status": verdict.status,
                           "new": verdict.new, "known": verdict.known,
                           "expected": [one for group in verdict.expected_groups
                                        for one in group.findings],
                           "absent": [{"VUID": one.id, "label": one.label}
                                      for one in verdict.absent],
                           "mistakes": list(map(group_data, verdict.new_groups)),
                           "unused_baseline": [entry.text for entry in verdict.unused_entries],
                           "headers": verdict.record.headers, "devices": verdict.record.devices,
                           "warnings": verdict.record.warnings(),
                           "advice": verdict.record.advice(),
                           "summaries": verdict.record.summaries})


def write_json_file(path, value):
    with open(path, "w", encoding="utf-8") as file:
        json.dump(value, file, indent=2, ensure_ascii=False)
        file.write("\n")


def escape_github(text, is_property=False):
    for character, escaped in (("%", "%25"), ("\r", "%0D"), ("\n", "%0A")):
        text = text.replace(character, escaped)
    if is_property:
        text = text.replace(":", "%3A").replace(",", "%2C")
    return text


def github_lines(verdict):
    """Returns annotations: GitHub shows them on the line that recorded the build, if it is known."""
    lines = []
    for note in mistake_lines(verdict) + [one.text for one in verdict.absent]:
        lines.append(f"::error title=Assay::{escape_github(note)}")
    for group in verdict.new_groups:
        place = first_place(group.first)
        where = ""
        if place:
            path = escape_github(os.path.relpath(place["file"]), is_property=True)
            where = f"file={path},line={place['line']},"
        title = escape_github(group.title, is_property=True)
        lines.append(f"::error {where}title={title}::{escape_github(full_text(group))}")
    return lines

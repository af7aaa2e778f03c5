# SPDX-License-Identifier: Apache-2.0
"""Reports for other programs: JUnit, SARIF, JSON and GitHub's annotations."""

import hashlib
import json
import os
import re
import xml.etree.ElementTree as ElementTree

# XML 1.0 allows no other control characters, escaped or not.
NOT_XML = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def xml_text(text):
    return NOT_XML.sub("\N{REPLACEMENT CHARACTER}", text)


def first_place(finding):
    """Returns the first frame of the call site whose source is known, or None."""
    return next((frame for frame in finding.get("call_site", []) if frame.get("file")), None)


def full_text(finding):
    """Returns the message with the specification's sentence and the place in the source."""
    text = finding["MainMessage"]
    if finding.get("SpecText"):
        text += f"\nThe Vulkan spec states: {finding['SpecText']}"
    if finding.get("SpecUrl"):
        text += f" ({finding['SpecUrl']})"
    place = first_place(finding)
    if place:
        text += f"\nat {place['file']}:{place['line']} in {place['function']}"
    return text


def by_id(findings):
    groups = {}
    for finding in findings:
        groups.setdefault(finding["VUID"], []).append(finding)
    return groups


def write_junit(path, verdict, name):
    """One test case an id: failed if it is new, skipped if the baseline has it. The first test case
    says whether the layer was loaded, so that a report is never empty."""
    new, known = by_id(verdict.new), by_id(verdict.known)
    known = {key: value for key, value in known.items() if key not in new}
    errors = 0 if verdict.is_loaded else 1
    root = ElementTree.Element("testsuites")
    suite = ElementTree.SubElement(root, "testsuite", name=xml_text(f"assay: {name}"),
                                   tests=str(1 + len(new) + len(known)), failures=str(len(new)),
                                   errors=str(errors), skipped=str(len(known)), time="0")

    def add_case(title):
        return ElementTree.SubElement(suite, "testcase", classname="assay", name=title, time="0")

    case = add_case("the layer was loaded")
    if errors:
        ElementTree.SubElement(case, "error", type="not loaded",
                               message="the layer was not loaded")
    for title, findings in sorted(new.items()):
        failure = ElementTree.SubElement(add_case(title), "failure", type=findings[0]["Severity"],
                                         message=xml_text(findings[0]["MainMessage"]))
        failure.text = xml_text("\n\n".join(map(full_text, findings)))
    for title, findings in sorted(known.items()):
        ElementTree.SubElement(add_case(title), "skipped",
                               message=f"in the baseline, {len(findings)} times")
    ElementTree.indent(root)
    ElementTree.ElementTree(root).write(path, encoding="utf-8", xml_declaration=True)


def sarif_location(finding):
    place = first_place(finding)
    names = [{"name": item.get("name") or item["handle"], "kind": item["type"]}
             for item in finding.get("Objects", [])]
    location = {}
    if place:
        # Paths are relative to the repository if they are in it, so that annotations find them.
        path = os.path.relpath(place["file"])
        if path.startswith(".."):
            uri = {"uri": "file://" + place["file"]}
        else:
            uri = {"uri": path.replace(os.sep, "/"), "uriBaseId": "%SRCROOT%"}
        location["physicalLocation"] = {"artifactLocation": uri,
                                        "region": {"startLine": max(1, place["line"])}}
    if names:
        location["logicalLocations"] = names
    return location


def fingerprint(finding):
    """Stays the same from run to run: handles and addresses are left out."""
    place = first_place(finding)
    parts = [finding["VUID"], finding.get("Location", ""), finding.get("DebugRegion", "")]
    parts += [item.get("name") or "" for item in finding.get("Objects", [])]
    if place:
        parts += [os.path.basename(place["file"]), place["function"]]
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()


def sarif_result(finding, is_known):
    result = {"ruleId": finding["VUID"],
              "level": {"Error": "error", "Warning": "warning"}.get(finding["Severity"], "note"),
              "message": {"text": finding["MainMessage"]},
              "partialFingerprints": {"assay/v1": fingerprint(finding)}}
    location = sarif_location(finding)
    if location:
        result["locations"] = [location]
    if is_known:
        result["suppressions"] = [{"kind": "external", "justification": "in the baseline"}]
    return result


def sarif_rule(finding):
    rule = {"id": finding["VUID"]}
    if finding.get("SpecText"):
        rule["fullDescription"] = {"text": finding["SpecText"]}
    if finding.get("SpecUrl"):
        rule["helpUri"] = finding["SpecUrl"]
    return rule


def write_sarif(path, verdict, command, status):
    findings = verdict.new + verdict.known
    header = verdict.record.headers[0] if verdict.record.headers else {}
    driver = {"name": "Assay", "rules": [sarif_rule(group[0]) for group in by_id(findings).values()]}
    if header.get("LayerVersion"):
        driver["version"] = header["LayerVersion"]
    invocation = {"executionSuccessful": verdict.is_loaded and status == 0}
    if command:
        invocation["commandLine"] = " ".join(command)
    run = {"tool": {"driver": driver},
           "invocations": [invocation],
           "results": [sarif_result(finding, False) for finding in verdict.new] +
                      [sarif_result(finding, True) for finding in verdict.known]}
    write_json_file(path, {"version": "2.1.0",
                           "$schema": "https://json.schemastore.org/sarif-2.1.0.json",
                           "runs": [run]})


def write_json(path, verdict, status):
    """The whole record in one object, with the verdict."""
    write_json_file(path, {"loaded": verdict.is_loaded, "status": status,
                           "new": verdict.new, "known": verdict.known,
                           "unused_baseline": [entry.text for entry in verdict.unused_entries],
                           "headers": verdict.record.headers, "devices": verdict.record.devices,
                           "warnings": verdict.record.warnings(),
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
    if not verdict.is_loaded:
        lines.append("::error title=Assay::The layer was not loaded.")
    for finding in verdict.new:
        place = first_place(finding)
        where = ""
        if place:
            path = escape_github(os.path.relpath(place["file"]), is_property=True)
            where = f"file={path},line={place['line']},"
        title = escape_github(finding["VUID"], is_property=True)
        lines.append(f"::error {where}title={title}::{escape_github(full_text(finding))}")
    return lines

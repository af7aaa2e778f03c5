#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Plays Assay's test cases with Assay and with the Khronos validation layer, and prints as a table how
many of the mistakes each of them reports, and what it reports of valid calls. A mistake counts as
found if a message has its id, or one that the registry has retired for it. Device builds' data is
played on lavapipe with the Khronos layer's GPU-assisted mode, all else on the null driver."""

import argparse
import collections
import datetime
import json
import pathlib
import subprocess
import sys
import tempfile

from judge import Judge
from play import names_of, play_list, read_expectations, twin_of
from table import Table

LAYER = "VK_LAYER_ASSAY_validation"
KHRONOS = "VK_LAYER_KHRONOS_validation"
FOLDERS = ("/etc/vulkan", "/usr/local/etc/vulkan", "/usr/local/share/vulkan", "/usr/share/vulkan")
REGISTRY = (1, 4, 363)  # whose ids the cases expect
COMMANDS = {"rules": ["calls"], "execution": ["execution"], "content": ["calls", "--submitted"]}
PLATFORMS = {"rules": "null", "execution": "null", "content": "lavapipe"}

# What cases do wrong before the build, which is of no concern to Assay. The Khronos layer would report
# it, and the case would end before the mistake that it is about.
MUTED = (
    "VUID-VkAccelerationStructureCreateInfo2KHR-addressRange-13122",
    "VUID-VkAccelerationStructureCreateInfoKHR-buffer-03615",
    "VUID-VkAccelerationStructureCreateInfoKHR-type-11600",
    "VUID-VkBindAccelerationStructureMemoryInfoNV-memoryOffset-03621",
    "VUID-VkBindAccelerationStructureMemoryInfoNV-size-03624",
    "VUID-VkBufferCreateInfo-flags-03338",
    "VUID-VkVideoBeginCodingInfoKHR-videoSession-07247",
    "VUID-vkBuildMicromapsEXT-micromapHostCommands-07555",
    "VUID-vkCreateAccelerationStructure2KHR-deviceAddressCommands-13086",
    "VUID-vkGetAccelerationStructureBuildSizesKHR-device-03618",
    "VUID-vkGetBufferDeviceAddress-device-03325",
    "WARNING-vkGetDeviceProcAddr-device",
)
MUTED_IN_PROGRAMS = (
    "VUID-vkCmdBuildAccelerationStructureNV-dst-02488",
    "VUID-vkCmdBuildAccelerationStructuresKHR-geometry-03673",
    "VUID-vkCmdWaitEvents-srcStageMask-01158",
    "VUID-vkDestroyDeferredOperationKHR-operation-03436",
    "VUID-vkSetEvent-event-09543",
)
# Programs about destroyed objects submit invalid command buffers as their mistake: they hear of these rules.
DESTROYED = "execution/destroyed"
MUTED_UNLESS_DESTROYED = (
    "VUID-vkQueueSubmit-pCommandBuffers-00070",
    "VUID-vkQueueSubmit-pCommandBuffers-00071",
    "VUID-vkQueueSubmit2-commandBuffer-03875",
)


# ---- the Khronos layer

def find_manifest():
    for folder in FOLDERS:
        for path in sorted(pathlib.Path(folder, "explicit_layer.d").glob("*.json")):
            if json.loads(path.read_text()).get("layer", {}).get("name") == KHRONOS:
                return path
    return None


def settings(program):
    """`program` is a key of PLATFORMS, or DESTROYED."""
    muted = MUTED + {"execution": MUTED_IN_PROGRAMS + MUTED_UNLESS_DESTROYED,
                     DESTROYED: MUTED_IN_PROGRAMS}.get(program, ())
    return (f"khronos_validation.gpuav_enable = {str(program == 'content').lower()}\n"
            "khronos_validation.enable_message_limit = false\n"
            "khronos_validation.debug_action = VK_DBG_LAYER_ACTION_CALLBACK\n"
            f"khronos_validation.message_id_filter = {','.join(muted)}\n")


def disguise(path, manifest, folder, text):
    """Variables with which the test programs, which ask for Assay by its name, get the other
    layer."""
    library = manifest["layer"]["library_path"]
    if library.startswith("."):
        library = str((path.parent / library).resolve())
    layer = {**manifest["layer"], "name": LAYER, "library_path": library}
    layer.pop("features", None)
    folder.mkdir()
    (folder / "layer.json").write_text(json.dumps({**manifest, "layer": layer}))
    (folder / "vk_layer_settings.txt").write_text(text)
    return {"ASSAY_TEST_LAYERS": str(folder), "VK_LAYER_SETTINGS_PATH": str(folder)}


# ---- the plays

def read_ids(dump):
    """Each id in scope, and the ids that count as the same: itself, and those that it replaces."""
    run = subprocess.run([dump], check=True, stdout=subprocess.PIPE, text=True)
    same = collections.defaultdict(set)
    for line in run.stdout.splitlines():
        fields = line.split("\t")
        same[fields[0]] |= {fields[0], *fields[6].split(",")} - {"-"}
    return same


def judge_list(judge, command, layer, list_name, names, each):
    """(name, ids that it breaks, verdict) of each play of a list."""
    with tempfile.TemporaryDirectory() as folder:
        ours, expected = read_expectations(command, list_name, folder)
    theirs = play_list(command, layer, list_name, names, each)
    for name in names:
        yield name, expected.get(name), judge.judge(
            name, ours.get(name), theirs.get(name), expected.get(name), theirs.get(twin_of(name)))


def play_all(arguments, layers, judge, details):
    table = Table()
    for program, platform in PLATFORMS.items():
        command = [str(arguments.tree / "tests/programs/programs_test"), platform, *COMMANDS[program]]
        lists = names_of(command)
        if not lists:
            table.left_out[f"{program} on {platform} cannot run here"] += 1
        for list_name, names in lists.items():
            if arguments.filter not in f"{program}.{list_name}":
                continue
            print(f"  {program}: {list_name}", file=sys.stderr, flush=True)
            layer = layers[DESTROYED if list_name.startswith(DESTROYED) else program]
            for name, expected, verdict in judge_list(judge, command, layer, list_name, names, arguments.each):
                table.count(program, name, verdict)
                if details:
                    details.write("\t".join((
                        program, name, ",".join(expected or ()), verdict.kind, verdict.outcome,
                        verdict.reason, ",".join(verdict.others), ",".join(verdict.alarms))) + "\n")
    return table


def print_notes(table, judge):
    print("\nCases that are not compared, and why:")
    for reason, count in table.left_out.most_common():
        print(f"  {count:6,}  {reason}")
    print("\nMessages of the Khronos layer that are no false alarms, by valid calls, and why:")
    for reason, names in sorted(judge.not_counted.items(), key=lambda item: -len(item[1])):
        print(f"  {len(names):6,}  {reason}")
    print("\nMuted, because cases break these rules before the build:")
    for name in sorted(MUTED + MUTED_IN_PROGRAMS + MUTED_UNLESS_DESTROYED):
        print(f"          {name}")


def main():
    parser = argparse.ArgumentParser(prog="scripts/bench findings --", description=__doc__)
    parser.add_argument("--tree", type=pathlib.Path, required=True, help=argparse.SUPPRESS)
    parser.add_argument("--khronos", type=pathlib.Path, metavar="MANIFEST",
                        help="the Khronos layer's manifest (default: the installed one)")
    parser.add_argument("--filter", metavar="TEXT", default="",
                        help="play only lists of cases whose names contain TEXT, such as "
                             "rules.calls/overlap")
    parser.add_argument("--each", action="store_true",
                        help="play each case in a process of its own (default: each list of cases, "
                             "until it crashes); takes an hour")
    parser.add_argument("--details", type=argparse.FileType("w"), metavar="FILE",
                        help="write a line for each play, with tabs between: program, play, ids that "
                             "it breaks, kind, outcome, reason, other ids, false alarms")
    arguments = parser.parse_args()
    path = arguments.khronos or find_manifest()
    if path is None:
        sys.exit("findings: the Khronos layer is missing: install it (on Debian, package "
                 "vulkan-validationlayers), or name its manifest with --khronos.")
    manifest = json.loads(path.read_text())
    version = manifest["layer"]["api_version"]
    if tuple(map(int, version.split("."))) < REGISTRY:
        print(f"findings: the Khronos layer {version} is older than the cases: it does not know all "
              "of their ids and structures.", file=sys.stderr)
    judge = Judge(read_ids(arguments.tree / "vuid-tables" / "vuid_dump"))
    with tempfile.TemporaryDirectory() as folder:
        layers = {program: disguise(path, manifest, pathlib.Path(folder, program.replace("/", "-")), settings(program))
                  for program in (*PLATFORMS, DESTROYED)}
        table = play_all(arguments, layers, judge, arguments.details)
    print(f"{KHRONOS} {version}, {datetime.date.today()}\n")
    total = table.print()
    print_notes(table, judge)
    counts = total.counts
    sys.exit(counts["found by Assay"] != counts["mistakes"] or counts["alarms of Assay"] != 0)


if __name__ == "__main__":
    main()

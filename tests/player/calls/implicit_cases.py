#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Generates implicit.cases: for each valid-usage id without a number of the commands about structures, the
calls that break it; and implicit_functions.inc, with the functions that edit these calls. What breaks an id is read in its sentence in validusage.json, not in vk.xml, from
which the checks are generated. An id whose sentence no pattern fits is an error."""

import argparse
import json
import pathlib
import re
import sys

# Where a scene has a structure of a call.
PLACES = {
    "VkCopyAccelerationStructureInfoKHR": "copy", "VkCopyMicromapInfoEXT": "copy",
    "VkCopyAccelerationStructureToMemoryInfoKHR": "to_memory",
    "VkCopyMicromapToMemoryInfoEXT": "to_memory",
    "VkCopyMemoryToAccelerationStructureInfoKHR": "from_memory",
    "VkCopyMemoryToMicromapInfoEXT": "from_memory",
    "VkAccelerationStructureCreateInfoKHR": "create",
    "VkAccelerationStructureCreateInfo2KHR": "create_at",
    "VkAccelerationStructureCreateInfoNV": "create_nv", "VkMicromapCreateInfoEXT": "create_micromap",
    "VkBindAccelerationStructureMemoryInfoNV": "bindings[0]", "VkMicromapBuildInfoEXT": "builds[0]",
    "VkAccelerationStructureBuildSizesInfoKHR": "sizes",
    "VkMicromapBuildSizesInfoEXT": "micromap_sizes",
    "VkAccelerationStructureDeviceAddressInfoKHR": "address_info",
    "VkAccelerationStructureCaptureDescriptorDataInfoEXT": "capture_info",
    "VkAccelerationStructureMemoryRequirementsInfoNV": "requirements_info",
    "VkAccelerationStructureVersionInfoKHR": "version", "VkMicromapVersionInfoEXT": "micromap_version",
    "VkAccelerationStructureMotionInfoNV": "motion",
    "VkWriteDescriptorSetAccelerationStructureKHR": "descriptor",
    "VkWriteDescriptorSetAccelerationStructureNV": "descriptor_nv",
    "VkWriteDescriptorSetPartitionedAccelerationStructureNV": "partition_descriptor",
    "VkClusterAccelerationStructureCommandsInfoNV": "cluster",
    "VkClusterAccelerationStructureInputInfoNV": "cluster.input",
    "VkClusterAccelerationStructureTriangleClusterInputNV": "cluster_triangles",
    "VkClusterAccelerationStructureClustersBottomLevelInputNV": "cluster_bottom_level",
    "VkClusterAccelerationStructureMoveObjectsInputNV": "cluster_moves",
    "VkBuildPartitionedAccelerationStructureInfoNV": "partition",
    "VkPartitionedAccelerationStructureInstancesInputNV": "partition.input",
    "VkPartitionedAccelerationStructureFlagsNV": "partition_flags",
}
# What a scene prepares so that its call has the structure.
PREPARES = {"VkAccelerationStructureMotionInfoNV": 
           # Without the flag, or the create info would also lack the structure.
           "life_use_motion(scene); scene->life.create.createFlags = 0;",
            "VkWriteDescriptorSetAccelerationStructureNV": "scene_use_nv_descriptor(scene);",
            "VkWriteDescriptorSetPartitionedAccelerationStructureNV": "scene_use_partition_descriptor(scene);",
            "VkClusterAccelerationStructureClustersBottomLevelInputNV":
            "scene_use_cluster_op(scene, VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_BUILD_CLUSTERS_BOTTOM_LEVEL_NV);",
            "VkClusterAccelerationStructureMoveObjectsInputNV":
            "scene_use_cluster_op(scene, VK_CLUSTER_ACCELERATION_STRUCTURE_OP_TYPE_MOVE_OBJECTS_NV);",
            "VkPartitionedAccelerationStructureFlagsNV":
            "scene->life.partition.input.pNext = &scene->life.partition_flags;"}
QUEUELESS = "queueless"
SETUPS = {"VkAccelerationStructureCaptureDescriptorDataInfoEXT": "VK_NV_ray_tracing",
          "VkAccelerationStructureMotionInfoNV": "$WITH_MOTION",
          "VkWriteDescriptorSetAccelerationStructureNV": "VK_NV_ray_tracing",
          "VkWriteDescriptorSetPartitionedAccelerationStructureNV": "$WITH_CLUSTERS"}
# Structures that others chain: the chain is wrong, too, if the sType is.
CHAINED = {"VkAccelerationStructureMotionInfoNV": "VkAccelerationStructureCreateInfoKHR_pNext_pNext",
           "VkPartitionedAccelerationStructureFlagsNV":
           "VkPartitionedAccelerationStructureInstancesInputNV_pNext_pNext"}
# Structures that are a part of others: that member is wrong, too.
EMBEDDED = {"VkClusterAccelerationStructureInputInfoNV":
            "VkClusterAccelerationStructureCommandsInfoNV_input_parameter",
            "VkPartitionedAccelerationStructureInstancesInputNV":
            "VkBuildPartitionedAccelerationStructureInfoNV_input_parameter"}
FORGED = "0xdeadbeef"
# Ids that the hand-written cases break for all commands alike.
BY_HAND = re.compile(r"^(commandBuffer|deferredOperation)-|^(input-parameter|device-parameter|renderpass|suspended|videocoding)$")


def fail(message):
    sys.exit(f"implicit_cases.py: {message}")


class Case:
    """A way to break an id: C statements, with what they are about as `it`."""

    def __init__(self, member, breaks, name="", **fields):
        self.member, self.breaks, self.name, self.fields = member, breaks, name, fields


def set_to(member, value):
    return f"SET(it {member}, {value});"


def of_pointer(member, before="", may_be_null=False):
    if not may_be_null:
        yield Case(member, f"{before}{set_to(member, '(uintptr_t)NULL')}", "null")
    yield Case(member, f"{before}{set_to(member, '(uintptr_t)unreadable_page()')}", "unreadable")


def of_chain(member):
    yield Case(member, f"{set_to(member, '(uintptr_t)life_stray()')}", "stray")
    yield Case(member, f"{set_to(member, '(uintptr_t)unreadable_page()')}", "unreadable")


def of_array(member, may_be_null):
    yield from of_pointer(member)
    yield Case(member, f"((uint64_t *)(uintptr_t)it {member})[1] = {FORGED};", "forged_element")
    if not may_be_null:
        yield Case(member, f"((uint64_t *)(uintptr_t)it {member})[1] = 0;", "null_element")


def of_handle(member, may_be_null):
    # The structure for capture takes one of two handles.
    other = set_to("accelerationStructure", "0") if member == "accelerationStructureNV" else ""
    yield Case(member, set_to(member, FORGED) + other, "forged")
    if not may_be_null:
        yield Case(member, set_to(member, "0"), "null")


def of_parent(member):
    yield Case(member, set_to(member, "life_object_of_other_device(scene)"))


def of_elements_parent(member):
    yield Case(member, f"((uint64_t *)(uintptr_t)it {member})[1] = life_object_of_other_device(scene);")


def of_stype(value, is_chained):
    wrong = f"{value} - 1" if is_chained else "VK_STRUCTURE_TYPE_MAX_ENUM"
    yield Case("sType", set_to("sType", wrong))


def of_unique(scope):
    uses = {"VkAccelerationStructureCreateInfoKHR": ("life_use_two_motions", "$WITH_MOTION"),
            "VkAccelerationStructureCreateInfo2KHR": ("life_use_two_captures", "$WITH_DESCRIPTOR_CAPTURE"),
            "VkAccelerationStructureCreateInfoNV": ("life_use_two_nv_captures", "$WITH_DESCRIPTOR_CAPTURE"),
            "VkPartitionedAccelerationStructureInstancesInputNV": ("life_use_two_partition_flags", None)}
    use, needed = uses[scope]
    yield Case("pNext", f"(void)&it sType; {use}(scene);", needed=needed)


def of_address(scope, member, may_be_null):
    yield Case(member, set_to(member, "UINT64_C(0x7000000000)"), "nowhere")
    if not may_be_null and member != "scratchData":
        yield Case(member, set_to(member, "0"), "null")


def of_selected(op_type, member):
    member = f"opInput.{member}"
    for case in of_pointer(member, set_to("opType", op_type)):
        yield case


MEMBER = r"(\w+)"
PATTERNS = [(re.compile(pattern), make) for pattern, make in (
    (r"sType must be (VK_STRUCTURE_TYPE_\w+)",
     lambda scope, m: of_stype(m[1], scope in CHAINED or "WriteDescriptorSet" in scope)),
    (r"pNext must be NULL( or a pointer to a valid instance of \w+)?", lambda scope, m: of_chain("pNext")),
    (r"Each pNext member of any structure .* must be either NULL or a pointer to a valid instance of .*",
     lambda scope, m: of_chain("pNext")),
    (r"The sType value of each structure in the pNext chain must be unique", lambda scope, m: of_unique(scope)),
    (rf"If {MEMBER} is not 0, {MEMBER} must be a valid VkDeviceAddress value",
     lambda scope, m: of_address(scope, m[2], True)),
    (rf"{MEMBER} must be a valid VkDeviceAddress value", lambda scope, m: of_address(scope, m[1], False)),
    (rf"If opType is (\w+)(?:, .*)?, the {MEMBER} member of opInput must be a valid pointer to a \w+ structure",
     lambda scope, m: of_selected(m[1], m[2])),
    (rf"{MEMBER} must be a valid Vk\w+ value",
     lambda scope, m: [Case(m[1], set_to(m[1], "0x7ffffff0"))]),
    (rf"If {MEMBER} is not 0, {MEMBER} must be a valid combination of Vk\w+ values",
     lambda scope, m: [Case(m[2], set_to(m[2], "0x40000000"))]),
    (rf"{MEMBER} must be 0", lambda scope, m: [Case(m[1], set_to(m[1], "1"))]),
    (rf"{MEMBER} must be greater than 0", lambda scope, m: [Case(m[1], set_to(m[1], "0"))]),
    (rf"{MEMBER} must be a valid Vk\w+ structure",
     lambda scope, m: [Case(m[1], f"it {m[1]}.sType = VK_STRUCTURE_TYPE_MAX_ENUM;"),
                       Case(m[1], f"SET(it {m[1]}.type, 77);", "type")]),
    (rf"{MEMBER} must be a valid pointer to an array of \w+ valid( or VK_NULL_HANDLE)? Vk\w+ handles",
     lambda scope, m: of_array(m[1], bool(m[2]))),
    (rf"{MEMBER} must be a valid Vk\w+ handle", lambda scope, m: of_handle(m[1], False)),
    (rf"If {MEMBER} is not VK_NULL_HANDLE, {MEMBER} must be a valid Vk\w+ handle",
     lambda scope, m: of_handle(m[2], True)),
    (rf"If {MEMBER} is not 0, and {MEMBER} is not NULL, {MEMBER} must be a valid pointer to an array of .*",
     lambda scope, m: of_pointer(m[3], set_to(m[3].replace("pp", "p", 1), "(uintptr_t)NULL"), True)),
    (rf"If {MEMBER} is not NULL, {MEMBER} must be a valid pointer to .*",
     lambda scope, m: of_pointer(m[2], may_be_null=True)),
    (rf"If {MEMBER} is not 0, {MEMBER} must be a valid pointer to an array of .*",
     lambda scope, m: of_pointer(m[2], set_to(m[1], "1"))),
    (rf"{MEMBER} must be a valid pointer to .*", lambda scope, m: of_pointer(m[1])),
    (rf"{MEMBER} must be a pointer value", lambda scope, m: of_pointer(m[1])),
    (rf"{MEMBER} must have been created, allocated, or retrieved from \w+", lambda scope, m: of_parent(m[1])),
    (rf"If {MEMBER} is a valid handle, it must have been created, allocated, or retrieved from \w+",
     lambda scope, m: of_parent(m[1])),
    (rf"Each element of {MEMBER} must have been created, allocated, or retrieved from \w+",
     lambda scope, m: of_elements_parent(m[1])),
    (rf"Both of {MEMBER}, and {MEMBER} (that are valid .*)?must have been created, .*",
     lambda scope, m: of_parent(m[1])),
    (rf"Each of commandBuffer, {MEMBER}, and {MEMBER} must have been created, .*",
     lambda scope, m: of_parent(m[1])),
    (rf"Each of commandBuffer, \w+, and the elements of {MEMBER} must have been created, .*",
     lambda scope, m: of_elements_parent(m[1])),
    (r"The device must have been created with at least 1 queue",
     lambda scope, m: [Case("device", "(void)&it device;", needed=QUEUELESS, clears=True)]),
)]
UNDECIDABLE = re.compile(r"If \w+ is not 0, \w+ must be a valid VkDeviceAddress value")


def cases_of(vuid, sentence):
    scope = vuid.split("-")[1]
    if UNDECIDABLE.fullmatch(sentence) and "CreateInfo" in scope:
        return
    for pattern, make in PATTERNS:
        if found := pattern.fullmatch(sentence):
            yield from make(scope, found)
            return
    fail(f"no pattern fits {vuid}: {sentence}")


def functions_of(number, scope, case):
    """The C functions of a case, and the name of the one that breaks the call."""
    name = f"implicit_{number}"
    if scope.startswith("vk"):
        breaks = re.sub(r"\bit ", f"arguments->{scope[2:]}.", case.breaks)
        clears = "    messages_clear(&scene->fixture->instance.messages);\n" * case.fields.get("clears", False)
        return (f"static void {name}_arguments(struct scene *scene, union life_arguments *arguments)\n"
                f"{{\n    (void)scene;\n    {breaks}\n}}\n"
                f"static void {name}(struct scene *scene)\n{{\n"
                f"{clears}    scene->life.edit = {name}_arguments;\n}}\n"), name
    place = PLACES[scope]
    breaks = re.sub(r"\bit ", f"scene->life.{place}.", case.breaks)
    return f"static void {name}(struct scene *scene)\n{{\n    {breaks}\n}}\n", name


def program(vuid, case, function):
    """The program that breaks an id by the edit of a function."""
    scope, tail = vuid.split("-", 2)[1:]
    rule = f"{scope}_{tail}".replace("-", "_")
    lines = [f"breaks {rule}"]
    needed = case.fields.get("needed") or SETUPS.get(scope)
    if needed == QUEUELESS:
        lines += [f"- with {needed}", "only null"]
    elif needed:
        lines.append(f"with {needed}")
    if scope in CHAINED and tail.startswith("sType"):
        names, reports = CHAINED[scope], "anything"
    else:
        names = EMBEDDED.get(scope) if case.member != "pNext" else None
        reports = case.member
    if names:
        lines.append(f"names {names}")
    if scope in PREPARES:
        lines.append(f"edit prepare_{scope}()")
    lines += [f"- edit {function}()", f"reports {reports}"]
    name = rule + (f"_{case.name}" if case.name else "")
    return f"case {name}: {'; '.join(lines)}\n"


def texts_of(sentences):
    """The programs, and the C functions that their edits call."""
    functions = [f"static void prepare_{scope}(struct scene *scene)\n{{\n    {body}\n}}\n"
                 for scope, body in PREPARES.items()]
    programs = []
    for vuid, sentence in sentences.items():
        scope, tail = vuid.split("-", 2)[1:]
        if BY_HAND.match(tail):
            continue
        for case in cases_of(vuid, sentence):
            text, name = functions_of(len(programs), scope, case)
            functions.append(text)
            programs.append(program(vuid, case, name))
    source = "generated by tests/player/calls/implicit_cases.py from validusage.json"
    return "".join([f"# These are {source}.\n", *programs]), "".join([f"/* These are {source}. */\n", *functions])


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--tables", type=pathlib.Path, required=True, help="vuid-tables/")
    parser.add_argument("--registry", type=pathlib.Path, required=True, help="validusage.json")
    parser.add_argument("--out", type=pathlib.Path, required=True, help="the folder to write to")
    arguments = parser.parse_args()
    sys.path.insert(0, str(arguments.tables))
    from plain_text import plain_text
    from signatures import read_commands
    names = read_commands(arguments.tables / "commands.def")
    scopes = {f"vk{name}" for name in names if re.search("Accel|Micromap", name)} | PLACES.keys()
    usage = json.loads(arguments.registry.read_text(encoding="utf-8"))
    sentences = {entry["vuid"]: plain_text(entry["text"])
                 for groups in usage["validation"].values() for group in groups.values()
                 for entry in group if entry["vuid"].split("-")[1] in scopes and
                 not re.search(r"-\d{5}$", entry["vuid"])}
    programs, functions = texts_of(sentences)
    (arguments.out / "implicit.cases").write_text(programs, encoding="utf-8")
    (arguments.out / "implicit_functions.inc").write_text(functions, encoding="utf-8")


if __name__ == "__main__":
    main()

# SPDX-License-Identifier: Apache-2.0
"""Messages of the Khronos validation layer as findings of a record.

The text has two forms. Layers before 1.4.309 write all of a message but its list of objects in one line;
later ones write a heading, the message, the specification's sentence and the objects."""

import re

# What later layers write in front of the heading is missing here; older ones begin with the id.
HEADING = re.compile(r"^(?:[^\n]*?\([A-Z ]+ / [A-Z]+\): msgNum: -?\d+ - )?"
                     r"Validation (?P<severity>[A-Z][A-Za-z ]*): \[ (?P<id>[^\n]+?) \]", re.M)
MESSAGE_ID = re.compile(r"\| MessageID = (0x[0-9a-f]+)(?: \||\n|$)")
OBJECTS = re.compile(r"^ *Objects: \d+\n(?:^ *\[\d+\].*\n?)*", re.M)
OLD_OBJECT = re.compile(r"Object \d+: handle = (0x[0-9a-f]+),(?: name = (.*?),)? type = VK_OBJECT_TYPE_(\w+);")
OBJECT = re.compile(r"^ +\[\d+\] (Vk\w+) (0x[0-9a-f]+)(?:\[(.*)\])?$", re.M)
SPECIFICATION = re.compile(r"\s*The Vulkan spec states: (.*?) \((https?://[^\s)]+)\)\s*$", re.S)
LAST_ONE = re.compile(r"\(Warning - This VUID has now been reported \d+ times.*?\)\.?\s*", re.S)
PLACE = re.compile(r"(vk\w+)(?:\(\))?:\s*(?:((?:p+[A-Z]\w*|\w+[.\[])[\w.\[\]>-]*)(?=[ ,(]))?")
VENDORS = ("KHR", "EXT", "NV", "NVX", "AMD", "AMDX", "INTEL", "GOOGLE", "FUCHSIA", "HUAWEI", "ARM", "QCOM")


def type_of(name):
    """Returns VkDeviceMemory for DEVICE_MEMORY."""
    return "Vk" + "".join(word if word in VENDORS else word.capitalize() for word in name.split("_"))


def objects_of(text):
    old = [{"type": type_of(kind), "handle": handle, **({"name": name} if name else {})}
           for handle, name, kind in OLD_OBJECT.findall(text)]
    return old or [{"type": kind, "handle": handle, **({"name": name} if name else {})}
                   for kind, handle, name in OBJECT.findall(text)]


def read_message(heading, text):
    """Returns the finding. `text`: what follows the heading, up to the next one."""
    objects = objects_of(text)
    number = MESSAGE_ID.search(text)
    message = OBJECTS.sub("", text[number.end():] if number else text)
    specification = SPECIFICATION.search(message)
    message = LAST_ONE.sub("", message[:specification.start()] if specification else message).strip()
    severity = heading["severity"]
    finding = {"Type": "Finding", "Layer": "Khronos", "VUID": heading["id"], "Objects": objects,
               "Severity": severity if severity in ("Error", "Warning") else
               "Warning" if "Warning" in severity else "Info",
               "MessageID": number[1] if number else "0x0", "MainMessage": message}
    place = PLACE.match(message)
    if place:
        finding["Function"] = place[1]
        finding.update({"Location": place[2]} if place[2] else {})
    if specification:
        finding.update(SpecText=specification[1], SpecUrl=specification[2])
    return finding


def read_messages(text):
    headings = list(HEADING.finditer(text))
    ends = [heading.start() for heading in headings[1:]] + [len(text)]
    return [read_message(heading, text[heading.end():end]) for heading, end in zip(headings, ends)]


def last_heading(text):
    """Returns where the last message begins: only those before it are known to be whole."""
    return max((heading.start() for heading in HEADING.finditer(text)), default=0)

# SPDX-License-Identifier: Apache-2.0
"""Resolves call sites, which the layer reports as module and offset, to functions and lines."""

import os
import re
import shutil
import subprocess

# The C library starts programs and threads. Its frames do not contain the mistake.
START = re.compile(r"/(libc|libpthread|ld-linux[^/]*|ld-musl[^/]*)[.-][^/]*$")
DISCRIMINATOR = re.compile(r" \(discriminator \d+\)$")


def unresolved_frames(findings):
    """Returns the offsets to resolve, by module."""
    modules = {}
    for finding in findings:
        for frame in finding.get("call_site", []):
            modules.setdefault(frame["module"], set()).add(frame["offset"])
    return modules


def place_of(frame):
    """Returns the frame in words: the line if it is known, else what is."""
    function = frame.get("function")
    if frame.get("file"):
        return f"{frame['file']}:{frame['line']} in {function}"
    module = f"{frame['module']}+{frame['offset']}"
    return f"{module} in {function}" if function else module


def with_callers(frames):
    """Adds, behind each frame, the functions that its function was inlined into."""
    return [one for frame in frames
            for one in (frame, *({"module": frame["module"], "offset": frame["offset"], **caller}
                                 for caller in frame.get("inlined_into", [])))]


def frames_of_application(finding):
    """Returns the frames up to the start of the program or thread; all if there are no others."""
    frames = with_callers(finding.get("call_site", []))
    return [frame for frame in frames if not START.search(frame["module"])] or frames


def first_place(finding):
    """Returns the first frame whose source is known, or None."""
    return next((frame for frame in frames_of_application(finding) if frame.get("file")), None)


def before_call(offset):
    """A return address is behind the call. One byte less lies within it, on the line of the call."""
    return hex(max(0, int(offset, 16) - 1))


def resolve_module(module, offsets):
    """Returns [(function, file, line)] by offset: the innermost inlined function comes first. Offsets
    without debug information are left out."""
    command = ["addr2line", "--addresses", "--functions", "--inlines", "--demangle", f"--exe={module}"]
    # Debug information that a server would have to send could take minutes.
    environment = {key: value for key, value in os.environ.items() if key != "DEBUGINFOD_URLS"}
    try:
        run = subprocess.run(command, input="\n".join(map(before_call, offsets)) + "\n",
                             stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env=environment,
                             timeout=120, check=True, encoding="utf-8", errors="replace")
    except (OSError, subprocess.SubprocessError):
        return {}
    groups = re.split(r"^0x[0-9a-f]+\n", run.stdout, flags=re.M)[1:]
    return {offset: places for offset, group in zip(offsets, groups)
            if (places := places_of_lines(group.splitlines()))}


def places_of_lines(lines):
    """Reads pairs of lines: a function, and a place in the source."""
    places = []
    for function, place in zip(lines[::2], lines[1::2]):
        file, _, line = DISCRIMINATOR.sub("", place).rpartition(":")
        if function != "??" or file != "??":
            places.append((function, None if file == "??" else os.path.normpath(file),
                           int(line) if line.isdigit() else 0))
    return places


def described(function, file, line):
    """Returns the members of a frame that name a place in the source."""
    members = {"function": function} if function != "??" else {}
    if file and line:
        members.update(function=function, file=file, line=line)
    return members


def resolve_call_sites(findings):
    """Adds function, file and line to the frames of findings. Returns whether addr2line is installed."""
    modules = unresolved_frames(findings)
    if not modules:
        return True
    if not shutil.which("addr2line"):
        return False
    places = {module: resolve_module(module, sorted(offsets)) if os.path.isabs(module) else {}
              for module, offsets in modules.items()}
    for finding in findings:
        for frame in finding.get("call_site", []):
            found = [described(*place) for place in places[frame["module"]].get(frame["offset"], [])]
            if found:
                frame.update(found[0])
            if found[1:]:
                frame["inlined_into"] = found[1:]
    return True

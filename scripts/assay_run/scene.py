# SPDX-License-Identifier: Apache-2.0
"""The 3D view on the page: the capture that the layer writes for it, and what assay-scene makes of that."""

import glob
import json
import pathlib
import re
import subprocess

from .environment import PREFIX, find_manifest_folder, split_paths

SCRIPTS = pathlib.Path(__file__).resolve().parent.parent
THREE = ("three.min.js", "examples/js/controls/OrbitControls.js")
LIMIT_MIB = 8          # of the data of all processes, before it is encoded
CAPTURE_MIB = 1024     # of a capture that only the page needs
MOST_PLACES = 1000     # of a finding
GEOMETRY = re.compile(r"eometries\[(\d+)")  # as src/scene/capture.c reads messages
PRIMITIVE = re.compile(r" (?:primitive|instance) (\d+)")
NO_PICTURE = "There is no picture, because "

LICENSE = """\
/* three.js and OrbitControls, https://threejs.org

The MIT License. Copyright (c) 2010-2019 three.js authors

Permission is hereby granted, free of charge, to any person obtaining a copy of this software and associated
documentation files (the "Software"), to deal in the Software without restriction, including without limitation the
rights to use, copy, modify, merge, publish, distribute, sublicense, and/or sell copies of the Software, and to
permit persons to whom the Software is furnished to do so, subject to the following conditions:

The above copyright notice and this permission notice shall be included in all copies or substantial portions of the
Software.

THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR IMPLIED, INCLUDING BUT NOT LIMITED TO THE
WARRANTIES OF MERCHANTABILITY, FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO EVENT SHALL THE AUTHORS OR
COPYRIGHT HOLDERS BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR
OTHERWISE, ARISING FROM, OUT OF OR IN CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE SOFTWARE. */
"""


def find_three(environment):
    """Returns the files of three.js as Debian's libjs-three has them, or None."""
    for base in split_paths(environment.get("XDG_DATA_DIRS") or "/usr/local/share:/usr/share"):
        files = [pathlib.Path(base) / "javascript/three" / name for name in THREE]
        if all(file.is_file() for file in files):
            return files
    return None


def find_assay_scene():
    """Returns the program that is installed beside assay-run, or was built with the layer; or None."""
    manifests = find_manifest_folder(SCRIPTS)
    places = [SCRIPTS.parent.parent / "bin", *([manifests.parent / "src/scene"] if manifests else [])]
    return next((place / "assay-scene" for place in places if (place / "assay-scene").is_file()), None)


class Scene:
    """What a run needs for the view. Without level content there is none, and nothing of this happens."""

    def __init__(self, folder, environment):
        """`folder` is for a capture that only the page needs."""
        self.folder, self.capture = pathlib.Path(folder), None
        self.three, self.program = find_three(environment), find_assay_scene()
        self.is_wanted, self.why = False, ""
        if not self.three:
            self.why = NO_PICTURE + "three.js is not installed (on Debian: libjs-three)."
        elif not self.program:
            self.why = NO_PICTURE + "assay-scene is not installed beside assay-run."

    def change(self, settings, environment):
        """Adds what the layer must be told to the settings of a run whose page is wanted."""
        def value_of(key):
            return settings.get(key, environment.get(PREFIX + key.upper(), ""))
        level = value_of("level") or ("content" if value_of("preset") in ("everything", "ci") else "")
        self.is_wanted = level == "content"
        if not self.is_wanted or self.why:
            return
        if not value_of("capture"):
            settings["capture"] = str(self.folder).replace("%", "%%") + "/scene-%p"
            settings.setdefault("capture_limit_mib", str(CAPTURE_MIB))
        self.capture = value_of("capture")

    def find_captures(self, processes):
        """Returns the folders that the processes of the run have written, with the number of the process."""
        pattern = re.sub("%(.)", lambda match: "%" if match[1] == "%" else "*", glob.escape(self.capture))
        found = []
        for path in sorted(map(pathlib.Path, {*glob.glob(pattern), *glob.glob(pattern + "-*")})):
            try:
                with open(path / "builds.jsonl", encoding="utf-8") as file:
                    pid = json.loads(file.readline()).get("pid")
            except (OSError, ValueError):
                continue
            process = next((i for i, (_, number) in enumerate(processes) if number == pid), None)
            if process is not None:
                found.append((path, process))
        return found

    def read_view(self, path, process, limit):
        output = self.folder / "view.json"
        run = subprocess.run([self.program, "view", path, output, "--limit", str(limit)], check=False,
                             stdin=subprocess.DEVNULL, capture_output=True, encoding="utf-8", errors="replace")
        if run.returncode != 0:
            self.why = f"{NO_PICTURE}assay-scene fails: {run.stderr.strip().removeprefix('assay-scene: ')}"
            return None
        return {**json.loads(output.read_text(encoding="utf-8")), "process": process}

    def data(self, processes):
        """Returns the data of the page; None if the run is without level content."""
        if not self.is_wanted:
            return None
        captures = [] if self.why else self.find_captures(processes)
        views = [self.read_view(*capture, max(1, LIMIT_MIB // len(captures))) for capture in captures]
        views = [view for view in views if view and view["moments"]]
        if not views and not self.why:
            self.why = NO_PICTURE + "the capture of this run has no build whose data it could show."
        return {"why": self.why, "views": views}

    def script(self):
        """Returns three.js, which has no text that a script cannot hold."""
        return LICENSE + "\n".join(file.read_text(encoding="utf-8") for file in self.three)


def writes_by_place(views):
    """Returns [view, write] by the place in which a finding names a build; None where several devices of a
    process, one after the other, have had the same handles."""
    places = {}
    for i, view in enumerate(views):
        for j, write in enumerate(view["writes"]):
            key = (view["process"], write["queue"], write["submission"], write["commandBuffer"], write["build"])
            places[key] = None if key in places else [i, j]
    return places


def number_in(pattern, text):
    match = pattern.search(text)
    return int(match[1]) if match else None


def places_in_scene(findings, places, writes, command_buffer_of):
    """Returns where findings are seen: the view and its write, the geometry, and the primitive or instance.
    `places` has the process, queue and submission of each."""
    shown = {}
    for finding, place in zip(findings, places):
        write = writes.get((place["process"], place["queue"], place["submission"], command_buffer_of(finding),
                            finding.get("build")))
        if write and len(shown) < MOST_PLACES:
            shown[(*write, number_in(GEOMETRY, finding.get("Location", "")),
                   number_in(PRIMITIVE, finding["MainMessage"]))] = None
    return [list(one) for one in shown]

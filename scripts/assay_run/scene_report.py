# SPDX-License-Identifier: Apache-2.0
"""The report about what was built: a capture, and what assay-scene report makes of it."""

import glob
import os
import pathlib
import subprocess

from .scene import find_assay_scene


class SceneFailure(Exception):
    """The report cannot be made; the text says why."""


def find_captures(folder):
    """Returns the captures of all processes and devices, the one with the most data first."""
    pattern = glob.escape(folder).replace("%p", "*").replace("%e", "*").replace("%%", "%") + "*"
    found = [path for path in map(pathlib.Path, glob.glob(pattern)) if (path / "builds.jsonl").is_file()]
    return sorted(found, key=lambda path: (-sum(file.stat().st_size for file in path.glob("data/*")), path))


def write_scene(page, folder, say):
    program = find_assay_scene()
    if not program:
        raise SceneFailure("assay-scene is not installed beside assay-run")
    captures = find_captures(folder)
    if not captures:
        raise SceneFailure("there is no capture: the application has built nothing under the layer")
    if len(captures) > 1:
        say(f"{len(captures)} devices have captures; the report is about the one with the most data")
    environment = {key: value for key, value in os.environ.items() if key != "VK_INSTANCE_LAYERS"}
    status = subprocess.run([program, "report", captures[0], "--html", page], env=environment, check=False).returncode
    if status:
        raise SceneFailure(f"{page}: assay-scene report ended with {status}")

# SPDX-License-Identifier: Apache-2.0
"""The environment that enables the layer in an application and its children."""

import glob
import os
import pathlib

LAYER = "VK_LAYER_ASSAY_validation"
KHRONOS = "VK_LAYER_KHRONOS_validation"
MANIFEST = "VkLayer_assay.json"
PREFIX = "VK_ASSAY_VALIDATION_"

# The loader's folders of explicit layers. VK_LAYER_PATH replaces them.
SYSTEM_FOLDERS = ("/usr/local/etc/vulkan/explicit_layer.d", "/etc/vulkan/explicit_layer.d",
                  "/usr/local/share/vulkan/explicit_layer.d", "/usr/share/vulkan/explicit_layer.d")


class EnvironmentFailure(Exception):
    """Something that the caller asked for cannot be found; the text says what."""


def find_build_tree(scripts):
    """Returns the folder of the layer's manifest in the repository of this script, or None.

    The newest build wins: it is the one that the user has just made."""
    manifests = [path for path in scripts.parent.glob(f"build/*/explicit_layer.d/{MANIFEST}")
                 if (path.parent.parent / "layer").is_dir()]
    return max(manifests, key=lambda path: path.stat().st_mtime).parent if manifests else None


def add_layer_path(environment, folder):
    """Adds a folder in front of those in which the loader looks for layers."""
    given = environment.get("VK_LAYER_PATH")
    folders = [given] if given else list(SYSTEM_FOLDERS)
    environment["VK_LAYER_PATH"] = os.pathsep.join([str(folder), *folders])


def enable_layers(environment, with_khronos):
    """Enables the layer in addition to those that the environment enables already. The first layer is
    nearest to the application."""
    layers = [name for name in environment.get("VK_INSTANCE_LAYERS", "").split(os.pathsep) if name]
    for name in ([KHRONOS] if with_khronos else []) + [LAYER]:
        if name not in layers:
            layers.append(name)
    environment["VK_INSTANCE_LAYERS"] = os.pathsep.join(layers)
    environment.pop("VK_ASSAY_DISABLE", None)


def find_lavapipe():
    """Returns the manifest of Mesa's CPU driver; its name has the architecture in some releases."""
    for folder in ("/usr/local/share", "/usr/share", "/etc"):
        found = sorted(glob.glob(f"{folder}/vulkan/icd.d/lvp_icd*.json"))
        if found:
            return found[0]
    raise EnvironmentFailure("lavapipe is not installed (on Debian: mesa-vulkan-drivers)")


def application_environment(arguments, records, base=os.environ):
    """Returns the environment for the application. Each process writes its record into `records`."""
    environment = dict(base)
    folder = find_build_tree(pathlib.Path(__file__).resolve().parent.parent)
    if folder:
        add_layer_path(environment, folder)
    enable_layers(environment, arguments.with_khronos)
    if arguments.lavapipe:
        environment["VK_DRIVER_FILES"] = environment["VK_ICD_FILENAMES"] = find_lavapipe()
    settings = dict(arguments.settings)
    for key in ("level", "backend"):
        if getattr(arguments, key):
            settings[key] = getattr(arguments, key)
    settings["log_format"] = "json"
    settings["log_filename"] = str(records / "%p.jsonl")
    settings.setdefault("report_flags", "error,warn")
    for key, value in settings.items():
        environment[PREFIX + key.upper()] = value
    return environment

# SPDX-License-Identifier: Apache-2.0
"""The environment that enables the layer in an application and its children."""

import glob
import os
import pathlib

from .baseline import read_baseline

LAYER = "VK_LAYER_ASSAY_validation"
KHRONOS = "VK_LAYER_KHRONOS_validation"
MANIFEST = "VkLayer_assay.json"
KHRONOS_MANIFEST = "VkLayer_khronos_validation.json"
LIBRARY = "libVkLayer_assay.so"
PREFIX = "VK_ASSAY_VALIDATION_"


class EnvironmentFailure(Exception):
    """Something that the caller asked for cannot be found; the text says what."""


def split_paths(text):
    return [path for path in (text or "").split(os.pathsep) if path]


def search_folders(environment, leaf):
    """Returns the folders that the loader searches, such as /usr/share/vulkan/LEAF, in its order."""
    home = environment.get("HOME", "")
    bases = [environment.get("XDG_CONFIG_HOME") or f"{home}/.config",
             *split_paths(environment.get("XDG_CONFIG_DIRS") or "/etc/xdg"),
             "/usr/local/etc", "/etc",
             environment.get("XDG_DATA_HOME") or f"{home}/.local/share",
             *split_paths(environment.get("XDG_DATA_DIRS") or "/usr/local/share:/usr/share")]
    return list(dict.fromkeys(f"{base}/vulkan/{leaf}" for base in bases))


def find_manifest_folder(scripts):
    """Returns the folder of the layer's manifest for this script, or None.

    Installed, it is in the same tree, which may have been unpacked anywhere. In the repository, the
    newest build wins: it is the one that the user has just made. Sanitized layers cannot be loaded
    by applications that are not."""
    installed = scripts.parent / "vulkan/explicit_layer.d"
    if scripts.name == "assay" and (installed / MANIFEST).is_file():
        return installed
    libraries = [path for path in scripts.parent.glob(f"build/*/layer/{LIBRARY}")
                 if path.parent.parent.name not in ("asan", "tsan") and
                 (path.parent.parent / "explicit_layer.d" / MANIFEST).is_file()]
    if not libraries:
        return None
    newest = max(libraries, key=lambda path: path.stat().st_mtime)
    return newest.parent.parent / "explicit_layer.d"


def add_layer_path(environment, folder):
    """Adds a folder in front of those in which the loader looks for layers. VK_LAYER_PATH replaces
    the loader's own; VK_ADD_LAYER_PATH is newer than some loaders."""
    given = split_paths(environment.get("VK_LAYER_PATH"))
    if any(os.path.isfile(f"{path}/{MANIFEST}") for path in given):
        return  # the user has chosen one
    folders = given or (split_paths(environment.get("VK_ADD_LAYER_PATH")) +
                        search_folders(environment, "explicit_layer.d"))
    environment["VK_LAYER_PATH"] = os.pathsep.join(
        dict.fromkeys([str(folder), *folders]))


def add_khronos_path(environment):
    """Adds the folder of the Khronos layer if VK_LAYER_PATH hides it. Loaders only warn of a layer that
    they do not find."""
    given = split_paths(environment.get("VK_LAYER_PATH"))
    installed = search_folders(environment, "explicit_layer.d")
    folders = given or split_paths(environment.get("VK_ADD_LAYER_PATH")) + installed
    if any(os.path.isfile(f"{folder}/{KHRONOS_MANIFEST}") for folder in folders):
        return
    found = [folder for folder in installed if os.path.isfile(f"{folder}/{KHRONOS_MANIFEST}")]
    if not found:
        raise EnvironmentFailure("the Khronos validation layer is not installed (on Debian: "
                                 "vulkan-validationlayers)")
    environment["VK_LAYER_PATH"] = os.pathsep.join([*given, found[0]])


def enable_layers(environment, with_khronos):
    """Enables the layer in addition to those that the environment enables already. The first layer is
    nearest to the application."""
    layers = split_paths(environment.get("VK_INSTANCE_LAYERS"))
    for name in ([KHRONOS] if with_khronos else []) + [LAYER]:
        if name not in layers:
            layers.append(name)
    environment["VK_INSTANCE_LAYERS"] = os.pathsep.join(layers)
    # The implicit layer may be another version of it.
    for name in ("VK_ASSAY_ENABLE", "VK_ASSAY_DISABLE"):
        environment.pop(name, None)
    if environment.get("VK_LOADER_LAYERS_DISABLE"):
        # Loaders from 1.3.262 on know this.
        allowed = environment.get("VK_LOADER_LAYERS_ALLOW")
        environment["VK_LOADER_LAYERS_ALLOW"] = f"{allowed},{LAYER}" if allowed else LAYER


def find_lavapipe(environment):
    """Returns the manifests of Mesa's CPU driver, one for each architecture; the loader skips those
    of other architectures. Their names have the architecture in some releases."""
    for folder in search_folders(environment, "icd.d"):
        found = sorted(glob.glob(f"{glob.escape(folder)}/lvp_icd*.json"))
        if found:
            return os.pathsep.join(found)
    raise EnvironmentFailure("lavapipe is not installed; in the repository, scripts/setup --layer --lavapipe installs it "
                             "(on Debian it is in mesa-vulkan-drivers, which needs version 25 to build structures)")


def with_errors(flags):
    """A run without errors in its record could not be judged."""
    words = [word.strip() for word in flags.split(",") if word.strip()]
    return ",".join(words if "error" in words else ["error", *words])


def with_log(actions):
    """Without an action that logs, there would be no record."""
    words = [word.strip() for word in actions.split(",")]
    words = [word for word in words if word and "ignore" not in word.lower()]
    has_log = any(name in word.lower() for word in words for name in ("default", "log_msg")) or \
        "log" in words
    return ",".join(words if has_log else ["log", *words])


def layer_settings(arguments, records, environment, scene=None):
    settings = dict(arguments.settings)
    for key in ("level", "backend"):
        if getattr(arguments, key):
            settings[key] = getattr(arguments, key)
    if arguments.everything:
        settings.setdefault("preset", "everything")
    settings["log_format"] = "json"
    settings["log_filename"] = str(records).replace("%", "%%") + "/%p.jsonl"
    # The environment wins over settings of the application, so these two are always in it.
    for key, default, correct in (("report_flags", "error,warn", with_errors),
                                  ("debug_action", "default", with_log)):
        given = environment.get(PREFIX + key.upper(), default)
        settings[key] = correct(settings.get(key, given))
    if PREFIX + "CRASH_REPORT" not in environment:
        settings.setdefault("crash_report", "true")
    if arguments.html and PREFIX + "RECORD_BUILDS" not in environment and \
            settings.get("level", environment.get(PREFIX + "LEVEL")) not in ("parameters", "state"):
        settings.setdefault("record_builds", "true")  # the lower levels know of no submissions
    if arguments.capture:
        settings["capture"] = os.path.abspath(arguments.capture)
        if PREFIX + "LEVEL" not in environment:
            settings.setdefault("level", "content")
    if scene:
        scene.change(settings, environment)
    if (arguments.advice_is_error or arguments.scene) and PREFIX + "ADVICE" not in environment:
        settings.setdefault("advice", "true")
    if arguments.baseline or arguments.write_baseline:
        # Otherwise known findings would use up the limit, and new ones of the same id be held back.
        settings.setdefault("enable_message_limit", "false")
    if arguments.baseline and PREFIX + "CALL_SITES" not in environment and \
            any(entry.needs_call_sites for entry in read_baseline(arguments.baseline)):
        settings.setdefault("call_sites", "full")
    return settings


def application_environment(arguments, records, base=os.environ, khronos=None, scene=None):
    """Returns the environment for the application. Each process writes its record into `records`.
    `khronos` is the log of the Khronos layer, if its findings count, `scene` what the page shows in 3D."""
    environment = dict(base)
    folder = find_manifest_folder(pathlib.Path(__file__).resolve().parent.parent)
    if folder and str(folder) not in search_folders(environment, "explicit_layer.d"):
        add_layer_path(environment, folder)
    if arguments.with_khronos:
        add_khronos_path(environment)
    enable_layers(environment, arguments.with_khronos)
    if khronos:
        khronos.change(environment)
    if arguments.lavapipe:
        environment["VK_DRIVER_FILES"] = environment["VK_ICD_FILENAMES"] = find_lavapipe(base)
        for name in ("VK_LOADER_DRIVERS_SELECT", "VK_LOADER_DRIVERS_DISABLE"):
            environment.pop(name, None)
    for key, value in layer_settings(arguments, records, environment, scene).items():
        environment[PREFIX + key.upper()] = value
    return environment

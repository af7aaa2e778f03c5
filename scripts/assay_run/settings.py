# SPDX-License-Identifier: Apache-2.0
"""The settings of the layer, as its manifest lists them, and the values that it takes."""

import difflib
import importlib.util
import json
import pathlib

from .environment import MANIFEST, find_manifest_folder

SCRIPTS = pathlib.Path(__file__).resolve().parent.parent
BOOLEANS = ("true", "false", "on", "off", "1", "0")
ACTION = "vk_dbg_layer_action_"


class SettingFailure(Exception):
    """A setting that the layer does not have, or a value that it would refuse; the text says which."""


def read_features():
    """Returns the manifest's list of settings; None if the layer that will be loaded is another one."""
    tables = SCRIPTS / "lib/tables.py"  # in the repository, from which the manifest is made
    folder = find_manifest_folder(SCRIPTS)
    try:
        if tables.is_file():
            spec = importlib.util.spec_from_file_location("tables", tables)
            module = importlib.util.module_from_spec(spec)
            spec.loader.exec_module(module)
            return module.features(SCRIPTS.parent)
        if folder:
            text = (folder / MANIFEST).read_text(encoding="utf-8")
            return json.loads(text)["layer"]["features"]
    except (OSError, ValueError, KeyError):
        pass
    return None


def list_settings(items):
    """Returns the settings by their keys; some stand below another one."""
    settings = {}
    for item in items:
        settings[item["key"]] = item
        settings.update(list_settings(item.get("settings", [])))
    return settings


def known_settings():
    """Returns the settings by their keys; None if the layer that will be loaded is another one."""
    features = read_features()
    return features and list_settings(features["settings"])


def words_of(setting):
    """Returns the values of a setting that has a list of them; None if it takes anything."""
    if setting["type"] == "BOOL":
        return BOOLEANS
    if setting["type"] not in ("ENUM", "FLAGS"):
        return None
    words = [flag["key"].lower() for flag in setting["flags"]]
    if setting["key"] == "debug_action":
        words += [ACTION + word for word in words] + [ACTION + "log_msg"]
    if setting["key"] == "report_flags":
        words += ["debug", "verbose"]  # the Khronos layer's
    return tuple(words)


def is_number(setting, value):
    least, most = (setting.get("range", {}).get(name) for name in ("min", "max"))
    return value.isdecimal() and (least is None or int(value) >= least) and \
        (most is None or int(value) <= most)


def is_valid(setting, value):
    words = words_of(setting)
    if setting["type"] == "INT":
        return is_number(setting, value)
    if words is None:
        return True
    given = value.split(",") if setting["type"] == "FLAGS" else [value]
    return all(word.strip().lower() in words for word in given)


def describe_values(setting):
    if setting["type"] == "INT":
        limits = setting.get("range", {})
        most = f" to {limits['max']}" if "max" in limits else " on"
        return f"a number from {limits.get('min', 0)}{most}"
    return ", ".join(words_of(setting))


def did_you_mean(word, known):
    close = difflib.get_close_matches(word, known, 1)
    return f" (did you mean {close[0]}?)" if close else ""


def check_settings(given):
    """Raises SettingFailure for the first of (key, value) that the layer would only warn about."""
    known = known_settings()
    if known is None:
        return
    for key, value in given:
        if key not in known:
            raise SettingFailure(f"--set {key}: the layer has no such setting{did_you_mean(key, known)}; "
                                 f"it has {', '.join(sorted(known))}")
        if not is_valid(known[key], value):
            raise SettingFailure(f"--set {key}={value}: not {describe_values(known[key])}")

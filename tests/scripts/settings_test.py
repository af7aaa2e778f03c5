#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The settings in the manifests are those of the layer: the same keys, defaults, choices and presets."""

import json
import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
KEY = re.compile(r'^    \{"(\w+)",\s+(\w+),\s+"[^"]*",\s+"([^"]*)"\},$', re.M)


def flatten(settings):
    for setting in settings:
        yield setting
        yield from flatten(setting.get("settings", []))


class Settings(unittest.TestCase):
    def setUp(self):
        features = json.loads((ROOT / "json" / "features.json").read_text(encoding="utf-8"))
        self.presets = features["presets"]
        self.settings = {setting["key"]: setting for setting in flatten(features["settings"])}
        self.source = (ROOT / "src" / "report" / "settings.c").read_text(encoding="utf-8")
        self.keys = {key: default for key, _, default in KEY.findall(self.source)}

    def test_keys(self):
        self.assertGreater(len(self.keys), 10)
        self.assertEqual(sorted(self.keys), sorted(self.settings))

    def test_names_in_the_environment(self):
        for key, setting in self.settings.items():
            self.assertEqual(setting["env"], "VK_ASSAY_VALIDATION_" + key.upper())

    def test_defaults(self):
        for key, setting in self.settings.items():
            default = setting["default"]
            text = ",".join(default) if isinstance(default, list) else str(default)
            text = text.replace("VK_DBG_LAYER_ACTION_", "").lower() or "none"
            self.assertEqual(text, self.keys[key], key)

    def test_choices(self):
        words = set(re.findall(r'\{"([\w]+)", \w+\}', self.source))
        for setting in self.settings.values():
            for flag in setting.get("flags", []):
                self.assertIn(flag["key"], words)

    def test_presets(self):
        for preset in self.presets:
            for chosen in preset["settings"]:
                setting = self.settings[chosen["key"]]
                flags = [flag["key"] for flag in setting.get("flags", [])]
                self.assertIn(chosen["value"], flags or [True, False])

    def test_presets_of_the_layer(self):
        """Vulkan Configurator has the layer's presets, but for the record of builds, which needs a log as
        JSON. It writes all settings to its file, so that the layer's own preset has no effect there."""
        shown = {preset["label"].lower(): {chosen["key"]: str(chosen["value"]).lower()
                                           for chosen in preset["settings"]} for preset in self.presets}
        values = re.findall(r'\{PRESET_(\w+), "(\w+)", "(\w+)"\},', self.source)
        made, expected = {}, {}
        for preset in dict.fromkeys(name for name, _, _ in values):  # each has what those before it have
            made.update({key: value for name, key, value in values
                         if name == preset and key != "record_builds"})
            expected[preset.lower()] = dict(made)
        self.assertEqual(sorted(expected), ["ci", "everything"])
        for preset, settings in expected.items():
            self.assertEqual(shown[preset], settings)
        self.assertEqual(self.settings["preset"]["view"], "HIDDEN")

    def test_sentences(self):
        for setting in self.settings.values():
            for part in [setting, *setting.get("flags", [])]:
                self.assertRegex(part["description"], r"^[A-Z].*\.$|none\.$")


if __name__ == "__main__":
    unittest.main()

# SPDX-License-Identifier: Apache-2.0
"""What scripts/lib/tables.py makes of the table of settings, and the files that it has written."""

import json
import pathlib
import re
import subprocess
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
TABLES = [sys.executable, "-B", str(ROOT / "scripts/lib/tables.py"), str(ROOT)]


def flatten(settings):
    for setting in settings:
        yield setting
        yield from flatten(setting.get("settings", []))


class Settings(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.features = json.loads(subprocess.check_output([*TABLES, "--print", "features"]))
        cls.settings = {setting["key"]: setting for setting in flatten(cls.features["settings"])}

    def test_files_are_up_to_date(self):
        self.assertEqual(subprocess.run(TABLES, stdout=subprocess.DEVNULL, check=False).returncode, 0)

    def test_stale_file(self):
        page = (ROOT / "docs/settings.md").read_text(encoding="utf-8")
        sys.path.insert(0, str(ROOT / "scripts/lib"))
        import tables  # pylint: disable=import-outside-toplevel,import-error
        self.assertEqual(tables.write_page(ROOT, page.replace("| `guard` |", "| `gard` |")), page)

    def test_defaults_and_presets_are_values(self):
        chosen = [(key, setting["default"]) for key, setting in self.settings.items()]
        chosen += [(one["key"], one["value"]) for preset in self.features["presets"] for one in preset["settings"]]
        for key, value in chosen:
            words = [flag["key"] for flag in self.settings[key].get("flags", [])]
            for word in value if isinstance(value, list) else [value]:
                self.assertTrue(not words or word in words, (key, word))

    def test_presets(self):
        """Vulkan Configurator has the layer's presets, but for the record of builds."""
        shown = {preset["label"]: {one["key"]: one["value"] for one in preset["settings"]}
                 for preset in self.features["presets"]}
        self.assertEqual(shown["CI"], {**shown["Everything"], "limits": "harsh"})
        self.assertNotIn("record_builds", shown["CI"])
        self.assertEqual(self.settings["preset"]["view"], "HIDDEN")

    def test_sentences(self):
        for setting in self.settings.values():
            for part in [setting, *setting.get("flags", [])]:
                self.assertRegex(part["description"], r"^[A-Z].*\.$")
                self.assertNotRegex(part["description"], r"`|\]\(")

    def test_what_a_setting_needs(self):
        self.assertIn("Needs level = content and backend = driver.", self.settings["guard"]["description"])
        self.assertEqual(self.settings["record_builds"]["dependence"]["settings"], [{"key": "log_format", "value": "json"}])

    def test_completions(self):
        words = subprocess.check_output([*TABLES, "--print", "completions"], encoding="utf-8").split()
        self.assertIn("guard=references", words)
        self.assertEqual({word.partition("=")[0] for word in words}, set(self.settings) - {"log_filename", "log_format"})

    def test_manual(self):
        manual = subprocess.check_output([*TABLES, "--print", "manual"], encoding="utf-8")
        self.assertEqual(re.findall(r"^\.B (\w+)$", manual, re.M), [
            line.split("`")[1] for line in (ROOT / "docs/settings.md").read_text(encoding="utf-8").partition(
                "<!-- settings -->")[2].partition("<!-- end")[0].splitlines()[3:]])


if __name__ == "__main__":
    unittest.main()

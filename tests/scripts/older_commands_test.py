# SPDX-License-Identifier: Apache-2.0
"""What layer/commands/generate.py makes of a row with AS(): each member of the newer structures has a
value, or the generator says which one has none."""

import pathlib
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path += [str(ROOT / "layer/commands"), str(ROOT / "vuid-tables")]
import generate  # noqa: E402
import signatures  # noqa: E402

REGISTRY = signatures.Registry(pathlib.Path(sys.argv.pop()))
COPY = "COMMAND(CmdCopyBuffer2) HAZARDS(hazards_copy_buffer(command, pCopyBufferInfo))\n"
SETS = "COMMAND(CmdBindDescriptorSets2) HAZARDS(hazards_bind_sets(recording, pBindDescriptorSetsInfo))\n"
PASS = "COMMAND(CreateRenderPass2) HAZARDS_SUCCESS(hazards_note_render_pass(layer, *pRenderPass, pCreateInfo))\n"
SUBMIT = "COMMAND(QueueSubmit2) CONTENT_THROUGH(snapshots_submit(layer, down, pSubmits))\n"


class OlderCommands(unittest.TestCase):
    def generate(self, newer, older):
        with tempfile.NamedTemporaryFile("w", suffix=".def") as file:
            file.write(newer + older)
            file.flush()
            return generate.Generator(REGISTRY, [pathlib.Path(file.name)]).entries_text()

    def fails(self, message, newer, older):
        with self.assertRaisesRegex(ValueError, message):
            self.generate(newer, older)

    def test_names(self):
        text = self.generate(COPY, "COMMAND(CmdCopyBuffer) AS(CmdCopyBuffer2)")
        self.assertIn(".srcBuffer = srcBuffer, .dstBuffer = dstBuffer, .regionCount = regionCount, .pRegions = "
                      "lower_VkBufferCopy2(&block, regionCount, pRegions)}", text)
        self.assertIn(".srcOffset = from[i].srcOffset, .dstOffset = from[i].dstOffset, .size = from[i].size}", text)
        self.assertIn('hazard_recording_begin(&recording, commandBuffer, "vkCmdCopyBuffer") && '
                      'hazard_recording_has(&recording, newer_pCopyBufferInfo->pRegions)', text)

    def test_members_of_a_structure(self):
        text = self.generate(PASS, "COMMAND(CreateRenderPass) AS(CreateRenderPass2, attachmentCount = 0, "
                                   "subpassCount = 0, correlatedViewMaskCount = 0, viewOffset = 0)")
        self.assertIn(".pNext = pCreateInfo->pNext, .flags = pCreateInfo->flags, .attachmentCount = 0, "
                      ".subpassCount = 0, .dependencyCount = pCreateInfo->dependencyCount", text)

    def test_a_member_without_a_value(self):
        self.fails("vkCmdBindDescriptorSets has nothing for VkBindDescriptorSetsInfo::stageFlags", SETS,
                   "COMMAND(CmdBindDescriptorSets) AS(CmdBindDescriptorSets2)")
        self.fails("vkCreateRenderPass has nothing for VkSubpassDependency2::viewOffset", PASS,
                   "COMMAND(CreateRenderPass) AS(CreateRenderPass2, attachmentCount = 0, subpassCount = 0, "
                   "correlatedViewMaskCount = 0)")

    def test_a_value_that_is_not_used(self):
        self.fails("gives values that are not used", COPY, "COMMAND(CmdCopyBuffer) AS(CmdCopyBuffer2, srcSet = 1)")

    def test_rows(self):
        self.fails("has no observers", "", "COMMAND(CmdCopyBuffer) AS(CmdCopyBuffer2)")
        self.fails("QueueSubmit has no CONTENT_THROUGH of its own", SUBMIT,
                   "COMMAND(QueueSubmit) AS(QueueSubmit2)")


if __name__ == "__main__":
    unittest.main()

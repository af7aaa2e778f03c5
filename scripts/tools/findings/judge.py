# SPDX-License-Identifier: Apache-2.0
"""Decides from what the test programs printed whether the Khronos layer found a mistake, and what it
said of valid calls."""

import collections
import re

NOT_READ = "an input of which nothing is read: the sentence makes no exception"

# Plays that say nothing about the Khronos layer: what is in the name, and the reason.
LEFT_OUT_PLAYS = (
    (r"of_(an_)?unknown_extension|of_the_future|of_a_future_", "uses an extension that no registry knows"),
    (r"dsts_perhaps_bound|dsts_bound_by_a_failed_call", "a bind has failed: what is bound is undefined"),
    (r"geometry_limit_met", "the preparation breaks the rule"),
    (r"nowhere_without_primitives", NOT_READ),
    (r"^execution/(messengers|records): ", "about Assay's own records and messengers"),
)

# Messages about valid calls that are not counted as false alarms, because the sentence alone does
# not say that the call is valid: what is in the id, in the text and in the play's name; the reason.
LEFT_OUT_MESSAGES = (
    (r"-03779$", r"Reference \(0\)", "",
     "a reference of 0 in a host build: the sentence makes no exception"),
    (r"KHR-pInfos-11702$", "NULL", "",
     "a host build of a kind that has no ranges: only the device command's sentence excepts it"),
    (r"-(11364|10894|11845|10427|02428|02431|02437|02439|11572)$", "", "", NOT_READ),
    (r"-(03771|03772|03774|03778)$", "", "without_primitives", NOT_READ),
    (r"-03799$", "", "of_zeros_of_nothing", NOT_READ),
    (r"-(07553|07554)$", "", "no_micromap_triangles", NOT_READ),
    (r"-09401$", "", "results_of_(other_queries|queries_never_reset)", "queries of other types are no concern of the case"),
    (r"-(03546|03547|03548)$", "", "", "an inactive box: the sentence makes no exception"),
    (r"-03673$", "Spheres", "", "buffers of spheres: the sentence does not name them"),
    (r"-03702$", "", "under_a_large_one", "how much of its dst a build accesses is not specified"),
    (r"-03702$", "", "instance_of_memory", "a device group without bufferDeviceAddressMultiDevice"),
    (r"-indexType-parameter$", "", "", "an index type whose extension is not enabled"),
    (r"", "", "(triangles_in_boxes|boxes_in_triangles)/", "the geometry of another type"),
)
# They come with all host builds, and find no mistake either.
OF_NO_MISTAKE = {reason for _, _, _, reason in LEFT_OUT_MESSAGES[:2]}

def reason_to_ignore(play, message):
    """Why a message about a valid call is no false alarm, or None."""
    for in_id, in_text, in_name, reason in LEFT_OUT_MESSAGES:
        if re.search(in_id, message.id) and re.search(in_text, message.text) and \
                re.search(in_name, play.name):
            return reason
    return None


def reason_to_leave_out(name, ours, theirs):
    for pattern, reason in LEFT_OUT_PLAYS:
        if re.search(pattern, name):
            return reason
    for play in (ours, theirs):
        if play is None:
            return "did not run"
        if play.outcome == "skipped":
            return "skipped: " + play.reason
    return None


class Verdict:
    def __init__(self, kind, reason=""):
        self.kind = kind  # mistake, valid, or left out
        self.reason = reason
        # For a mistake: found, another id, missed, crashed, or hung; and whether Assay found it. For a
        # valid play: crashed, hung, or nothing.
        self.outcome = ""
        self.others = []  # ids of which none was expected
        self.assay = False
        # For a valid call: ids of false alarms, and whether the layer crashed; and the same for Assay.
        self.is_valid_call = False
        self.alarms = []
        self.crashed = False
        self.assay_alarmed = False


class Judge:
    def __init__(self, same):
        """`same`: each id in scope -> the ids that count as the same."""
        self.same = same
        self.scope = {name for names in same.values() for name in names}
        # Reason -> valid plays of which a message is not counted for it.
        self.not_counted = collections.defaultdict(set)

    def judge(self, name, ours, theirs, expected, twin=None):
        """`expected`: the ids that the play breaks. `twin`: the Khronos layer's play of its twin, if there
        is one."""
        reason = reason_to_leave_out(name, ours, theirs)
        if twin and not expected:
            reason = "a mistake that has a warning of Assay's own, or only words"
        if reason:
            return Verdict("left out", reason)
        verdict = Verdict("mistake" if expected else "valid")
        verdict.is_valid_call = not expected
        if expected:
            verdict.assay = ours.outcome == "passed"
            self.judge_mistake(verdict, theirs, expected, twin)
        else:
            verdict.assay_alarmed = ours.outcome != "passed"
            verdict.crashed = theirs.outcome in ("crashed", "hung")
            verdict.outcome = theirs.outcome if verdict.crashed else ""
            verdict.alarms = self.alarms(theirs)
        return verdict

    def alarms(self, play):
        """Ids in scope that the Khronos layer reported of valid calls."""
        alarms = set()
        for message in [] if play.is_early else play.messages:
            reason = reason_to_ignore(play, message)
            if reason is None and message.id in self.scope:
                alarms.add(message.id)
            else:
                reason = reason or f"no rule about builds: {message.id}"
                self.not_counted[reason].add(play.name)
        return sorted(alarms)

    def judge_mistake(self, verdict, play, expected, twin):
        accepted = {name for id_ in expected for name in self.same.get(id_, {id_})}
        found = {message.id for message in play.messages
                 if reason_to_ignore(play, message) not in OF_NO_MISTAKE}
        known = {message.id for message in (twin.messages if twin else ())}
        verdict.others = sorted(found - accepted - known)
        if play.outcome in ("crashed", "hung"):
            verdict.outcome = play.outcome
        elif play.outcome == "passed" or accepted & found or play.found_all():
            verdict.outcome = "found"
        else:
            verdict.outcome = "another id" if verdict.others else "missed"
        if play.is_early and verdict.outcome == "missed":
            verdict.kind, verdict.reason = "left out", "the preparation breaks other rules"

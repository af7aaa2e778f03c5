// SPDX-License-Identifier: Apache-2.0
// The payload of a ray of the pipeline: the index of its answer, and the number of its candidates.
struct Payload
{
    Hit closest;
    uint place, count;
};

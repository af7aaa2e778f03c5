// SPDX-License-Identifier: Apache-2.0
// What a ray of the pipeline carries: its place among the answers, and how many candidates were met.
struct Payload
{
    Hit closest;
    uint place, count;
};

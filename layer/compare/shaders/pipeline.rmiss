// SPDX-License-Identifier: Apache-2.0
// A miss needs no code: the payload is initialized to a miss.
#version 460
#extension GL_EXT_ray_tracing : require

void main() {}

// SPDX-License-Identifier: Apache-2.0
// The payload says so already.
#version 460
#extension GL_EXT_ray_tracing : require

void main() {}

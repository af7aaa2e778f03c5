// SPDX-License-Identifier: Apache-2.0
// Records the nearest triangle.
#version 460
#extension GL_EXT_ray_tracing : require
#extension GL_GOOGLE_include_directive : require
#include "data.glsl"
#include "payload.glsl"

layout(location = 0) rayPayloadInEXT Payload payload;
hitAttributeEXT vec2 barycentrics;

void main()
{
    uint side = gl_HitKindEXT == gl_HitKindFrontFacingTriangleEXT ? FRONT : 0;
    payload.closest = Hit(gl_HitTEXT, barycentrics.x, barycentrics.y, HIT | side, gl_GeometryIndexEXT,
                          gl_PrimitiveID, gl_InstanceID, 0);
}

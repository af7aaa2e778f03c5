/* SPDX-License-Identifier: Apache-2.0 */
/* The addresses of input data in a scene, and how messages name them. */
#ifndef RULES_ADDRESSES_H
#define RULES_ADDRESSES_H

#include "case.h"

#define VERTEX TRIANGLES(INDEXED, 0).vertexData.deviceAddress
#define UNINDEXED_VERTEX TRIANGLES(UNINDEXED, 0).vertexData.deviceAddress
#define INDEX TRIANGLES(INDEXED, 0).indexData.deviceAddress
#define SHORT_INDEX TRIANGLES(UNINDEXED, 1).indexData.deviceAddress
#define TRANSFORM TRIANGLES(INDEXED, 0).transformData.deviceAddress
#define UNINDEXED_TRANSFORM TRIANGLES(UNINDEXED, 0).transformData.deviceAddress
#define BOX BOXES(AABBS, 0).data.deviceAddress
#define INSTANCE INSTANCES(TLAS, 0).data.deviceAddress

#define VERTEX_PATH "pInfos[0].pGeometries[0].geometry.triangles.vertexData.deviceAddress"
#define INDEX_PATH "pInfos[0].pGeometries[0].geometry.triangles.indexData.deviceAddress"
#define TRANSFORM_PATH "pInfos[0].pGeometries[0].geometry.triangles.transformData.deviceAddress"
#define BOX_PATH "pInfos[2].pGeometries[0].geometry.aabbs.data.deviceAddress"
#define INSTANCE_PATH "pInfos[3].pGeometries[0].geometry.instances.data.deviceAddress"

#define WILD 0x7000000000ull

#endif

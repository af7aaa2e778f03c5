/* SPDX-License-Identifier: Apache-2.0 */
/* Before rules.def is included to walk the rows of some subjects: makes RULE ask ASK_subject, which
 * for every subject is nothing. Define that of the subject to be walked anew. No include guard:
 * included before each walk. */
#undef ASK_call
#undef ASK_build
#undef ASK_geometry
#undef ASK_range
#undef ASK_address
#undef ASK_indirect
#undef ASK_indirect_range
#undef ASK_host_build
#undef ASK_host_geometry
#undef ASK_pair
#undef ASK_motion_build
#undef ASK_motion_triangles
#undef ASK_motion_instance
#undef ASK_spheres
#undef ASK_swept_spheres
#undef ASK_micromap_build
#undef ASK_micromap_geometry
#undef ASK_micromap_data
#undef ASK_opacity
#undef ASK_opacity_ext
#undef ASK_displacement
#undef ASK_nv_call
#undef ASK_nv_info
#undef ASK_nv_geometry
#undef ASK_dense_build
#undef ASK_dense
#undef ASK_used_micromap
#undef ASK_updated_micromap
#undef ASK_box
#undef ASK_radius
#undef ASK_micromap_triangle
#undef ASK_opacity_index
#undef ASK_instance
#undef ASK_nv_instance
#undef ASK_instance_pointer
#undef ASK_reference
#undef ASK_indices
#undef ASK_transform
#undef ASK_update
#undef ASK_updated_geometry
#undef ASK_updated_dense
#define ASK_call(name, level)
#define ASK_build(name, level)
#define ASK_geometry(name, level)
#define ASK_range(name, level)
#define ASK_address(name, level)
#define ASK_indirect(name, level)
#define ASK_indirect_range(name, level)
#define ASK_host_build(name, level)
#define ASK_host_geometry(name, level)
#define ASK_pair(name, level)
#define ASK_motion_build(name, level)
#define ASK_motion_triangles(name, level)
#define ASK_motion_instance(name, level)
#define ASK_spheres(name, level)
#define ASK_swept_spheres(name, level)
#define ASK_micromap_build(name, level)
#define ASK_micromap_geometry(name, level)
#define ASK_micromap_data(name, level)
#define ASK_opacity(name, level)
#define ASK_opacity_ext(name, level)
#define ASK_displacement(name, level)
#define ASK_nv_call(name, level)
#define ASK_nv_info(name, level)
#define ASK_nv_geometry(name, level)
#define ASK_dense_build(name, level)
#define ASK_dense(name, level)
#define ASK_used_micromap(name, level)
#define ASK_updated_micromap(name, level)
#define ASK_box(name, level)
#define ASK_radius(name, level)
#define ASK_micromap_triangle(name, level)
#define ASK_opacity_index(name, level)
#define ASK_instance(name, level)
#define ASK_nv_instance(name, level)
#define ASK_instance_pointer(name, level)
#define ASK_reference(name, level)
#define ASK_indices(name, level)
#define ASK_transform(name, level)
#define ASK_update(name, level)
#define ASK_updated_geometry(name, level)
#define ASK_updated_dense(name, level)
#define PENDING(name, level, waits_for, ids)
#define RULE(subject, name, level, ids) ASK_##subject(name, level)

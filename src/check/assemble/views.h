/* SPDX-License-Identifier: Apache-2.0 */
/* Makes views of calls, builds and geometries: what is readable of the application's arrays, and
 * the facts about the handles and addresses in them. */
#ifndef ASSAY_CHECK_ASSEMBLE_VIEWS_H
#define ASSAY_CHECK_ASSEMBLE_VIEWS_H

#include "src/check/walk/context.h"

/* Fills the flags of a call view: which arrays are readable. */
void view_call(struct check_context *context, struct call_view *call);

/* Fills a build view from parameters alone. view_build() has one caller, the loop over the builds
 * of a call: a second one would cost 30 instructions a build, because it is no longer inlined. */
void view_build(struct check_context *context, const struct call_view *call, uint32_t index,
                struct build_view *build);
/* Fills the view of a build whose sizes are queried. The query gives the primitive counts as
 * maximum counts. */
void view_sized_build(struct check_context *context, const struct call_view *call,
                      struct build_view *build);
void view_geometry(struct check_context *context, const struct build_view *build, uint32_t index,
                   struct geometry_view *geometry);

/* Gets the primitive count that the call gives for a geometry. Returns false if it is
 * unreadable. */
bool view_primitive_count(const struct build_view *build, uint32_t geometry, uint32_t *count);

/* Add facts from the state about handles and addresses: in one batch of up to VIEWS_MAX builds and
 * the first geometry of each, or of one geometry. */
enum { VIEWS_MAX = 16 };
void view_builds_found(struct check_context *context, struct build_view *builds,
                       struct geometry_view *first_geometries, unsigned count);
void view_geometry_found(struct check_context *context, struct geometry_view *geometry);

/* Adds the remaining facts, after view_builds_found() or view_geometry_found(). */
void view_build_state(struct check_context *context, struct build_view *build);
void view_geometry_state(struct check_context *context, struct geometry_view *geometry);

/* Queries the sizes of a build if its parameters are well-formed. `holds`: its rules about
 * parameters, and those of its geometries, are known to hold. */
void view_build_sizes(struct check_context *context, struct build_view *build, bool holds);

#endif

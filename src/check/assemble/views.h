/* SPDX-License-Identifier: Apache-2.0 */
/* Making views: what of the application's arrays can be read, and what the state knows of the
 * things they name. */
#ifndef ASSAY_CHECK_ASSEMBLE_VIEWS_H
#define ASSAY_CHECK_ASSEMBLE_VIEWS_H

#include "src/check/walk/context.h"

/* Fills the flags of a call view. */
void view_call(struct check_context *context, struct call_view *call);

/* Fills a build view from parameters alone. */
void view_build(struct check_context *context, const struct call_view *call, uint32_t index,
                struct build_view *build);
void view_geometry(struct check_context *context, const struct build_view *build, uint32_t index,
                   struct geometry_view *geometry);

/* The primitive count that the call gives for a geometry; false if it can't be read. */
bool view_primitive_count(const struct build_view *build, uint32_t geometry, uint32_t *count);

/* Adds what the state knows of handles and addresses: of up to VIEWS_MAX builds and the first
 * geometry of each that has one, together; of one geometry. */
enum { VIEWS_MAX = 16 };
void view_builds_found(struct check_context *context, struct build_view *builds,
                       struct geometry_view *first_geometries, unsigned count);
void view_geometry_found(struct check_context *context, struct geometry_view *geometry);

/* Adds the rest. */
void view_build_state(struct check_context *context, struct build_view *build);
void view_geometry_state(struct check_context *context, struct geometry_view *geometry);

/* Asks for the sizes of a build, if its parameters are sound. `holds`: their rules, and those of
 * its geometries, are known to hold. */
void view_build_sizes(struct check_context *context, struct build_view *build, bool holds);

/* Whether a build has the shape, and so the sizes, of the context's recent build. */
bool view_is_like_recent(const struct check_context *context, const struct build_view *build);
/* Makes it that build, if its sizes are known. */
void view_keep_recent(const struct check_context *context, const struct build_view *build,
                      bool holds);

#endif

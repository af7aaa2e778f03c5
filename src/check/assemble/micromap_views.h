/* SPDX-License-Identifier: Apache-2.0 */
/* Makes the views of micromaps: which micromap structures a geometry has, and the facts about the
 * objects and addresses in them. */
#ifndef ASSAY_CHECK_ASSEMBLE_MICROMAP_VIEWS_H
#define ASSAY_CHECK_ASSEMBLE_MICROMAP_VIEWS_H

#include "src/check/walk/context.h"
#include "src/view/micromap_view.h"

/* Each fills a view from parameters alone. Returns false if the geometry lacks the structure. */
bool view_micromap_data(struct check_context *context, const struct geometry_view *geometry,
                        struct micromap_data_view *view);
bool view_opacity(const struct geometry_view *geometry, struct opacity_view *view);
bool view_opacity_ext(struct check_context *context, const struct geometry_view *geometry,
                      struct opacity_ext_view *view);
bool view_displacement(struct check_context *context, const struct geometry_view *geometry,
                       struct displacement_view *view);

/* Each adds facts from the state and lists the addresses among the geometry's chained inputs. */
void view_micromap_data_state(struct check_context *context, struct geometry_view *geometry,
                              struct micromap_data_view *view);
void view_opacity_state(struct check_context *context, struct geometry_view *geometry,
                        struct opacity_view *view);
void view_opacity_ext_state(struct check_context *context, struct geometry_view *geometry,
                            struct opacity_ext_view *view);
void view_displacement_state(struct check_context *context, struct displacement_view *view);

#endif

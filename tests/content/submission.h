/* SPDX-License-Identifier: Apache-2.0 */
/* Submitting a scene's command buffer without waiting for it, and waiting in several ways. */
#ifndef CONTENT_SUBMISSION_H
#define CONTENT_SUBMISSION_H

#include "variant.h"

/* Ends the command buffer of the call; a secondary one gets a primary one around it. */
void submission_prepare(struct scene *scene);

/* Submits it, behind what the scene submitted before; with a fence. May be done again when it is
 * complete. */
void submission_begin(struct scene *scene);
/* Until everything is complete that may still use what the scene made: a semaphore is signaled
 * before a fence is. */
void submission_finish(struct scene *scene);
void submission_wait(struct scene *scene, enum waiting waiting);

#endif

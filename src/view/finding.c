/* SPDX-License-Identifier: Apache-2.0 */
/* Fills findings. */
#include "src/view/finding.h"

bool finding_fill(struct finding *finding, const char *field, const char *says,
                  const struct value *values, uint32_t value_count)
{
    finding->also_count = finding->remark_count = 0;
    finding->has_instance = false;
    finding->more = 0;
    finding->reported_with = RULE_COUNT;
    finding->field = field;
    finding->says = says;
    finding->value_count = value_count < FINDING_VALUES ? value_count : FINDING_VALUES;
    for (uint32_t i = 0; i < finding->value_count; i++)
        finding->values[i] = values[i];
    return false;
}

bool finding_add_remark(struct finding *finding, const char *says, const struct value *values,
                        uint32_t value_count)
{
    if (finding->remark_count == FINDING_REMARKS)
        return false;
    struct remark *remark = &finding->remarks[finding->remark_count++];
    *remark = (struct remark){
        .says = says, .value_count = value_count < REMARK_VALUES ? value_count : REMARK_VALUES};
    for (uint32_t i = 0; i < remark->value_count; i++)
        remark->values[i] = values[i];
    return false;
}

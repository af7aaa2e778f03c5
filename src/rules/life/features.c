/* SPDX-License-Identifier: Apache-2.0 */
/* Rules about features that only commands which build no structures need. */
#include "src/rules/predicates.h"

static bool feature_is_enabled(struct finding *finding, bool feature, const char *name)
{
    return feature ||
           violated(finding, "", "requires {}, which is not enabled for the device", phrase(name));
}

bool micromap_feature_is_enabled(const struct call_view *call, struct finding *finding)
{
    return feature_is_enabled(finding, call->device->micromap.ext,
                              "VkPhysicalDeviceOpacityMicromapFeaturesEXT::micromap");
}

bool micromap_host_commands_feature_is_enabled(const struct call_view *call,
                                               struct finding *finding)
{
    return feature_is_enabled(finding, call->device->micromap.host_commands,
                              "VkPhysicalDeviceOpacityMicromapFeaturesEXT::micromapHostCommands");
}

bool device_address_commands_feature_is_enabled(const struct call_view *call,
                                                struct finding *finding)
{
    return feature_is_enabled(
        finding, call->device->device_address_commands,
        "VkPhysicalDeviceDeviceAddressCommandsFeaturesKHR::deviceAddressCommands");
}

bool descriptor_capture_feature_is_enabled(const struct call_view *call, struct finding *finding)
{
    return feature_is_enabled(
        finding, call->device->descriptor_buffer_capture_replay,
        "VkPhysicalDeviceDescriptorBufferFeaturesEXT::descriptorBufferCaptureReplay");
}

bool multi_device_address_feature_is_enabled(const struct call_view *call, struct finding *finding)
{
    return !call->device->is_group ||
           feature_is_enabled(
               finding, call->device->buffer_device_address_multi_device,
               "VkPhysicalDeviceBufferDeviceAddressFeatures::bufferDeviceAddressMultiDevice");
}

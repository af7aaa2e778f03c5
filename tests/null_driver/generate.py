# SPDX-License-Identifier: Apache-2.0
"""Generates the null driver's tables and stubs from the registry: extensions and entry points
(generated.h), the structures of features, the function of each entry point and what it does by
default (stubs.c), the sType of each structure (structures.h), the features of extensions (device_features.h),
and the parameters of commands (vulkan_commands.h)."""

import argparse
import fnmatch
import pathlib
import re
import sys

sys.path.append(str(pathlib.Path(__file__).parents[2] / "vuid-tables"))
import signatures

# The extensions that the driver offers, without VK_.
INSTANCE_EXTENSIONS = """
    EXT_debug_utils KHR_device_group_creation KHR_external_fence_capabilities
    KHR_external_memory_capabilities KHR_external_semaphore_capabilities
    KHR_get_physical_device_properties2"""
DEVICE_EXTENSIONS = """
    AMDX_dense_geometry_format AMD_buffer_marker EXT_buffer_device_address EXT_conditional_rendering
    EXT_descriptor_buffer EXT_descriptor_indexing EXT_device_fault
    EXT_external_memory_host EXT_host_query_reset EXT_index_type_uint8 EXT_opacity_micromap EXT_robustness2
    EXT_private_data EXT_scalar_block_layout KHR_16bit_storage KHR_8bit_storage
    KHR_acceleration_structure KHR_bind_memory2 KHR_buffer_device_address KHR_copy_commands2
    KHR_create_renderpass2 KHR_dedicated_allocation KHR_deferred_host_operations
    KHR_depth_stencil_resolve KHR_descriptor_update_template KHR_device_address_commands
    KHR_device_group KHR_draw_indirect_count KHR_driver_properties KHR_dynamic_rendering
    KHR_external_fence KHR_external_fence_fd KHR_external_memory KHR_external_memory_fd
    KHR_external_semaphore KHR_external_semaphore_fd
    KHR_format_feature_flags2 KHR_get_memory_requirements2 KHR_image_format_list
    KHR_imageless_framebuffer KHR_index_type_uint8 KHR_maintenance1 KHR_maintenance2
    KHR_maintenance3 KHR_maintenance4 KHR_maintenance5 KHR_maintenance6 KHR_map_memory2
    KHR_multiview KHR_opacity_micromap KHR_pipeline_library KHR_push_descriptor KHR_ray_query
    KHR_ray_tracing_maintenance1 KHR_ray_tracing_pipeline KHR_ray_tracing_position_fetch
    KHR_sampler_ycbcr_conversion KHR_shader_draw_parameters KHR_shader_float16_int8
    KHR_shader_float_controls KHR_spirv_1_4 KHR_storage_buffer_storage_class
    KHR_swapchain KHR_synchronization2
    KHR_timeline_semaphore KHR_uniform_buffer_standard_layout KHR_variable_pointers
    KHR_video_decode_h264 KHR_video_decode_queue KHR_video_queue KHR_vulkan_memory_model
    NV_cluster_acceleration_structure NV_displacement_micromap NV_low_latency2
    NV_partitioned_acceleration_structure NV_ray_tracing NV_ray_tracing_linear_swept_spheres
    NV_ray_tracing_motion_blur"""

# Constants of the driver: values of members, by patterns of their names. The last pattern that fits a
# member counts; a member that none fits is 0. Limits are those that anything asks for, mostly the
# required minimum.
CONSTANTS = {
    "VkPhysicalDeviceLimits default_limits": {
        "1 << 20": "maxPerStage* maxDescriptorSet*",
        "16384": "maxImageDimension* maxFramebufferWidth maxFramebufferHeight",
        "{16384, 16384}": "maxViewportDimensions",
        "2048": "maxImageDimension3D maxImageArrayLayers maxVertexInputBindingStride "
                "maxFramebufferLayers",
        "2047": "maxVertexInputAttributeOffset",
        "1 << 27": "maxTexelBufferElements",
        "65536": "maxUniformBufferRange",
        "UINT32_MAX": "maxStorageBufferRange maxMemoryAllocationCount maxDraw*",
        "256": "maxPushConstantsSize",
        "4096": "maxSamplerAllocationCount minMemoryMapAlignment",
        "(VkDeviceSize)1 << 40": "sparseAddressSpaceSize",
        "128": "maxVertexOutputComponents maxFragmentInputComponents",
        "49152": "maxComputeSharedMemorySize",
        "{65535, 65535, 65535}": "maxComputeWorkGroupCount",
        "1024": "maxComputeWorkGroupInvocations",
        "{1024, 1024, 64}": "maxComputeWorkGroupSize",
        "{-32768, 32768}": "viewportBoundsRange",
        "32": "maxVertexInputAttributes maxVertexInputBindings",
        "16": "maxDescriptorSet*Dynamic maxFragmentCombinedOutputResources maxSamplerLodBias "
              "maxSamplerAnisotropy maxViewports min*BufferOffsetAlignment",
        "8": "maxBoundDescriptorSets maxFragmentOutputAttachments *PrecisionBits "
             "maxColorAttachments maxClipDistances max*CullDistances max*ClipAndCullDistances",
        "7": "maxTexelOffset",
        "-8": "minTexelOffset",
        "1": "bufferImageGranularity maxSampleMaskWords timestamp* strictLines "
             "standardSampleLocations optimalBufferCopy*",
        "2": "discreteQueuePriorities",
        "64": "nonCoherentAtomSize",
        "{1, 64}": "pointSizeRange",
        "{1, 8}": "lineWidthRange",
        "0.125f": "pointSizeGranularity lineWidthGranularity",
        "VK_SAMPLE_COUNT_1_BIT | VK_SAMPLE_COUNT_4_BIT": "*SampleCounts",
    },
    "VkPhysicalDeviceVulkan11Properties vulkan11": {
        '"null driver"': "driverUUID",
        "1": "deviceNodeMask",
        "32": "subgroupSize",
        "VK_SHADER_STAGE_ALL": "subgroupSupportedStages",
        "VK_SUBGROUP_FEATURE_BASIC_BIT": "subgroupSupportedOperations",
        "6": "maxMultiviewViewCount",
        "(1 << 27) - 1": "maxMultiviewInstanceIndex",
        "VK_TRUE": "protectedNoFault",
        "1 << 20": "maxPerSetDescriptors",
        "(VkDeviceSize)1 << 38": "maxMemoryAllocationSize",
    },
    "VkPhysicalDeviceVulkan12Properties vulkan12": {
        '"null driver"': "driverName",
        '"executes nothing"': "driverInfo",
        "{1, 3, 0, 0}": "conformanceVersion",
        "1 << 20": "max*UpdateAfterBind*",
        "16": "max*UpdateAfterBind*Dynamic",
        "VK_RESOLVE_MODE_SAMPLE_ZERO_BIT": "supported*ResolveModes",
        "UINT64_MAX": "maxTimelineSemaphoreValueDifference",
        "VK_SAMPLE_COUNT_1_BIT": "framebufferIntegerColorSampleCounts",
    },
    "VkPhysicalDeviceVulkan13Properties vulkan13": {
        "32": "minSubgroupSize maxSubgroupSize maxComputeWorkgroupSubgroups",
        "4": "max*InlineUniformBlocks",
        "256": "maxInlineUniformBlockSize",
        "4096": "maxInlineUniformTotalSize",
        "16": "*TexelBufferOffsetAlignmentBytes",
        "(VkDeviceSize)1 << 38": "maxBufferSize",
    },
    "VkPhysicalDeviceVulkan14Properties vulkan14": {"32": "maxPushDescriptors"},
}

# What commands do that creates or destroys nothing, and is about no state but that of one object. They
# return VK_SUCCESS if nothing else is said, and have their parameters of the registry.
BODIES = {
    "GetInstanceProcAddr": "return entry_find(pName);",
    "GetDeviceProcAddr": "return entry_find_device(OBJECT(device), pName);",
    "EnumerateInstanceVersion": "*pApiVersion = config_current().api_version;",
    "GetPhysicalDeviceMemoryProperties2":
        "pMemoryProperties->memoryProperties = CONFIG(physicalDevice)->memory;",
    "GetPhysicalDeviceExternalBufferProperties":
        "pExternalBufferProperties->externalMemoryProperties = (VkExternalMemoryProperties){"
        "VK_EXTERNAL_MEMORY_FEATURE_EXPORTABLE_BIT | VK_EXTERNAL_MEMORY_FEATURE_IMPORTABLE_BIT, "
        "pExternalBufferInfo->handleType, pExternalBufferInfo->handleType};",
    "GetDeviceGroupPeerMemoryFeatures": "*pPeerMemoryFeatures = VK_PEER_MEMORY_FEATURE_COPY_DST_BIT | "
                                        "VK_PEER_MEMORY_FEATURE_GENERIC_SRC_BIT;",
    "GetBufferDeviceAddress GetBufferOpaqueCaptureAddress":
        "const struct object *object = FIND(BUFFER, pInfo->buffer); "
        "return object && buffer_has_usage(pInfo->buffer, VK_BUFFER_USAGE_2_SHADER_DEVICE_ADDRESS_BIT) ? "
        "object->buffer.address : 0;",
    "GetDeviceMemoryOpaqueCaptureAddress":
        "const struct object *object = FIND(DEVICE_MEMORY, pInfo->memory); "
        "return object != NULL ? object->memory.address : 0;",
    "GetDeviceMemoryCommitment":
        "const struct object *object = FIND(DEVICE_MEMORY, memory); "
        "*pCommittedMemoryInBytes = object != NULL ? object->memory.size : 0;",
    "GetMemoryFdPropertiesKHR": "pMemoryFdProperties->memoryTypeBits = requirements_types("
                                "CONFIG(device), 0, VK_MEMORY_PROPERTY_PROTECTED_BIT);",
    "GetMemoryHostPointerPropertiesEXT":
        "pMemoryHostPointerProperties->memoryTypeBits = requirements_types("
        "CONFIG(device), VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT, 0);",
    "BeginCommandBuffer ResetCommandBuffer":
        "if (OBJECT(commandBuffer)->type == VK_OBJECT_TYPE_COMMAND_BUFFER) "
        "transfers_release(OBJECT(commandBuffer));",
    "QueueWaitIdle DeviceWaitIdle": "return sync_wait_idle();",
    "WriteAccelerationStructuresPropertiesKHR":
        "query_write(accelerationStructureCount, queryType, dataSize, pData, stride);",
    "WriteMicromapsPropertiesEXT":
        "query_write(micromapCount, queryType, dataSize, pData, stride);",
    "GetMicromapBuildSizesEXT": "pSizeInfo->micromapSize = 4096; pSizeInfo->discardable = VK_FALSE; "
                                "pSizeInfo->buildScratchSize = CONFIG(device)->needs_no_scratch ? 0 : 1024;",
    "GetImageSubresourceLayout":
        "const struct object *object = FIND(IMAGE, image); "
        "*pLayout = (VkSubresourceLayout){.size = object != NULL ? object->image.size : 0};",
    "GetImageSubresourceLayout2": "null_GetImageSubresourceLayout(device, image, NULL, "
                                  "&pLayout->subresourceLayout);",
    "GetRenderAreaGranularity GetRenderingAreaGranularity": "*pGranularity = (VkExtent2D){1, 1};",
    "GetRayTracingShaderGroupHandlesKHR GetRayTracingCaptureReplayShaderGroupHandlesKHR":
        "memset(pData, 0, dataSize);",
    "GetRayTracingShaderGroupStackSizeKHR": "return 64;",
    "AllocateDescriptorSets":
        "return objects_create(FIND(DESCRIPTOR_POOL, pAllocateInfo->descriptorPool), "
        "VK_OBJECT_TYPE_DESCRIPTOR_SET, pAllocateInfo->descriptorSetCount, pDescriptorSets);",
    "GetDescriptorSetLayoutSupport": "pSupport->supported = VK_TRUE;",
    # What is done to an object that is created.
    "CreateAccelerationStructure2KHR": "object->as.fallback = pCreateInfo->addressRange.address;",
    "CreateQueryPool": "object->query_type = pCreateInfo->queryType;",
}
BODIES = {name: body for names, body in BODIES.items() for name in names.split()}

HEAD = "/* Generated by tests/null_driver/generate.py from vk.xml. */\n"


class Registry(signatures.Registry):
    """The registry, and the part of it that the driver offers."""

    def __init__(self, path):
        super().__init__(path)
        self.instance = {"VK_" + name for name in INSTANCE_EXTENSIONS.split()}
        self.device = {"VK_" + name for name in DEVICE_EXTENSIONS.split()}
        self.extensions = {extension.get("name"): extension
                           for extension in self.tree.iterfind("extensions/extension")}

    def members_of(self, name):
        """The type of each member of a structure but sType and pNext, by its name."""
        return {member.name: member.type for member in self.structures[name].members
                if member.name not in ("sType", "pNext")}

    def is_chained(self, name):
        """Whether a type is a structure that has an sType."""
        return name in self.structures and self.structures[name].type is not None

    def promoted(self, name):
        """The guard of the core version that an extension has become part of."""
        while not (to := self.extensions[name].get("promotedto", "")).startswith("VK_VERSION_"):
            if to not in self.extensions:
                return "NEVER"
            name = to
        return to[len("VK_VERSION_") - 1:].replace("_", "V", 1)

    def is_met(self, depends):
        """Whether the driver offers what an expression of extensions and versions names."""
        offered = self.instance | self.device
        if depends is None:
            return True
        python = re.sub(r"\w+(::\w+)?", lambda name: str(
            name[0].startswith("VK_VERSION_") or name[0] in offered), depends)
        return eval(python.replace("+", " and ").replace(",", " or "))

    def owned(self, kind):
        """Yields the guard and the name of each command, or type, that the driver offers."""
        blocks = [(f"V{block.get('number').replace('.', '_')}", block)
                  for block in self.tree.iterfind("feature") if signatures.is_of_vulkan(block)]
        blocks += [("V1_0", self.extensions[name]) for name in sorted(self.instance)]
        blocks += [(name[3:], self.extensions[name]) for name in sorted(self.device)]
        for guard, block in blocks:
            for require in block.iterfind("require"):
                if signatures.is_of_vulkan(require) and self.is_met(require.get("depends")):
                    for item in require.iterfind(kind):
                        yield guard, item.get("name")


class Command:
    def __init__(self, registry, command):
        self.registry = registry
        self.name, self.returns, self.parameters = command.target, command.returns, command.parameters
        self.names = [parameter.name for parameter in command.parameters]
        self.types = [parameter.type for parameter in command.parameters]
        self.signature = f"{self.returns} null_{self.name}({command.declaration})"
        self.init = f"void init_{self.name}(struct object *object, " \
                    f"const {self.types[1]} *pCreateInfo)" if self.is_creation() else None

    def level(self):
        return {"VkPhysicalDevice": "PHYSICAL", "VkDevice": "DEVICE", "VkQueue": "DEVICE",
                "VkCommandBuffer": "DEVICE"}.get(self.types[0], "INSTANCE")

    def default(self):
        """Returns the statements of a command that no file of the driver defines."""
        if self.name in BODIES and not self.is_creation():
            own = [BODIES[self.name]]
            return own + ["return VK_SUCCESS;"] * (self.returns == "VkResult" and "return " not in own[0])
        if by_newer := self.by_newer():
            return by_newer
        deferred = "deferred_start(device, deferredOperation)"
        is_deferred = "deferredOperation" in self.names
        handle = self.registry.handles.get(self.types[-1])
        if self.is_creation():
            return [f"struct object *object = object_create(OBJECT({self.names[0]}), {handle}, "
                    "NULL);",
                    "if (object == NULL)",
                    "    return VK_ERROR_OUT_OF_HOST_MEMORY;",
                    f"init_{self.name}(object, pCreateInfo);",
                    f"*{self.names[-1]} = HANDLE({self.types[-1]}, object->handle);",
                    "return VK_SUCCESS;"]
        if self.name.startswith("Create") and handle:
            count = self.parameters[-1].lengths[0] or "1"
            return [f"const VkResult result = objects_create(OBJECT({self.names[0]}), {handle}, "
                    f"{count}, {self.names[-1]});",
                    f"return result == VK_SUCCESS ? {deferred} : result;" if is_deferred
                    else "return result;"]
        if is_deferred:
            return [f"return {deferred};"]
        if self.name.startswith(("Destroy", "Free")) and self.names[-1] == "pAllocator":
            kind = self.registry.handles[self.types[-2]]
            if len(self.names) == 2:
                return [f"object_destroy_dispatchable({self.names[0]}, {kind});"]
            return [f"object_destroy(RAW({self.names[1]}), {kind});"]
        lengths = {parameter.lengths[0] for parameter in self.parameters}
        counts = [name for name in self.names if name in lengths and name.startswith("p")]
        statements = [f"*{name} = 0;" for name in counts]
        if self.name.startswith("Get") and self.returns == "void" and not counts and \
                self.types[-1] != "void":
            statements = [f"fill_with_zeros({self.names[-1]}, sizeof(*{self.names[-1]}), "
                          f"{int(self.registry.is_chained(self.types[-1]))});"]
        return statements + ([] if self.returns == "void" else ["return 0;"])

    def by_newer(self):
        """Returns the statements of a query that has a newer form, which takes a structure in place
        of parameters, or fills in a structure of which the query wants a part; else None."""
        newer = self.registry.commands.get(self.name + "2")
        if not newer or not self.name.startswith(("Get", "Map")) or self.parameters[-1].lengths[0]:
            return None
        newer = Command(self.registry, newer)
        own = dict(zip(self.names, self.types))
        given = []
        for name, kind in list(zip(newer.names, newer.types))[:-1]:
            if own.get(name) == kind:
                given.append(name)
            elif inside := [member for member in self.registry.members_of(kind) if member in own]:
                members = ", ".join(f".{member} = {member}" for member in inside)
                given.append(f"&(const {kind}){{{members}}}")
            else:
                return None
        call, whole = f"null_{newer.name}({', '.join(given)}, ", newer.types[-1]
        returned = "" if self.returns == "void" else "return "
        if whole == self.types[-1]:
            return [f"{returned}{call}{self.names[-1]});"]
        parts = [member for member, kind in self.registry.members_of(whole).items()
                 if kind == self.types[-1]]
        if not parts:
            return None
        result = "const VkResult result = " if returned else ""
        kind = self.registry.structures[whole].type
        return [f"{whole} whole = {{.sType = {kind}}};", f"{result}{call}&whole);",
                f"*{self.names[-1]} = whole.{parts[0]};"] + ["return result;"] * bool(returned)

    def is_creation(self):
        """Whether it creates one object as a structure says."""
        return self.name.startswith("Create") and self.names[1:2] == ["pCreateInfo"] \
            and self.types[-1] in self.registry.handles

    def source(self):
        call = f"null_{self.name}({', '.join(self.names)})"
        if self.returns == "VkResult":
            entry = [f"const VkResult failure = entry_count(ENTRY_{self.name});",
                     f"return failure != VK_SUCCESS ? failure : {call};"]
        else:
            entry = [f"entry_count(ENTRY_{self.name});",
                     call + ";" if self.returns == "void" else f"return {call};"]
        functions = [(f"__attribute__((weak)) {self.init}", [BODIES.get(self.name, "")])] \
            if self.init else []
        functions += [(f"__attribute__((weak)) {self.signature}", self.default()),
                      (f"static {self.signature.replace(' null_', ' entry_')}", entry)]
        return "".join(f"\n{head}\n{{\n" + "".join(f"    {line}\n" for line in body) + "}\n"
                       for head, body in functions)


def read_commands(registry):
    """Returns the offered commands, and (level, name, target, guard) of each name of one."""
    commands = {command.target: Command(registry, command) for command in registry.commands.values()}
    rows = {}
    for guard, name in registry.owned("command"):
        command = commands[registry.commands[name[2:]].target]
        guard = guard if command.level() == "DEVICE" else "V1_0"
        rows[name] = (command.level(), name[2:], command.name, guard)
    offered = {target for _, _, target, _ in rows.values()}
    return ([command for command in commands.values() if command.name in offered],
            sorted(rows.values(), key=lambda row: row[1]))


def feature_rows(registry):
    """Yields the initializer of each struct feature_row."""
    structures = registry.structures
    homes = {member: (name, structures[name].type)
             for name in (f"VkPhysicalDeviceVulkan1{minor}Features" for minor in range(1, 5))
             for member in registry.members_of(name)}
    core = "VkPhysicalDeviceFeatures2"
    rows = {}
    for guard, name in registry.owned("type"):
        name = structures[name].name if name in structures else None
        if name and (name == core or core in structures[name].extends):
            rows[guard, name] = structures[name]
    of_core = {name for guard, name in rows if guard.startswith("V1_")}
    for (guard, name), structure in rows.items():
        kind = structure.type
        members = list(registry.members_of("VkPhysicalDeviceFeatures" if name == core else name))
        owner, home = homes.get(members[0], (name, kind)) if name in of_core else (name, kind)
        first = "features" if name == core else members[0]
        is_beta = "VK_" + guard in registry.extensions and \
            registry.extensions["VK_" + guard].get("platform") == "provisional"
        row = f"    {{{kind}, {guard}, {16 + 4 * len(members)}, {home}, " \
              f"offsetof({owner}, {first})}},\n"
        yield f"#ifdef VK_{guard}\n{row}#endif\n" if is_beta else row


def header(registry, commands):
    """Extensions in the order of the core version that includes them."""
    extensions = sorted((registry.promoted(name), name[3:]) for name in registry.device)
    return "".join([
        HEAD, "#define EXTENSIONS(EXTENSION)",
        *(f" \\\n    EXTENSION({name}, {promoted})" for promoted, name in extensions),
        "\n\n#define ENTRIES(ENTRY)",
        *(f" \\\n    ENTRY({command.name})" for command in commands),
        "\n\n#define CREATIONS(CREATION)",
        *(f" \\\n    CREATION({command.name})" for command in commands if command.init), "\n\n",
        *(f"#define COMMAND_{command.name} {command.signature}\n" for command in commands),
        *(f"#define ON_CREATION_{command.name} {command.init}\n"
          for command in commands if command.init)])


def structures(registry):
    """What MAKE (tests/fixture/make.h) needs: the sType of each structure, by the structure's name."""
    return HEAD + "".join(f"#define {name}_sType {structure.type}\n"
                          for name, structure in registry.structures.items() if structure.type)


def features(registry):
    """What device_wish (tests/fixture/device_wish.c) needs: each feature, and the structures of the features of an
    extension, unless a structure of Vulkan 1.1 to 1.3 has them all."""
    structures, core = registry.structures, "VkPhysicalDeviceFeatures2"
    in_core = {member for minor in range(1, 4) for member in registry.members_of(f"VkPhysicalDeviceVulkan1{minor}Features")}
    rows, of_extensions = {core: [f"features.{name}" for name in registry.members_of("VkPhysicalDeviceFeatures")]}, []
    for guard, name in registry.owned("type"):
        name = structures[name].name if name in structures else None
        if not name or core not in structures[name].extends:
            continue
        rows[name] = [member for member in registry.members_of(name)]
        if not guard.startswith("V1_") and not in_core.issuperset(rows[name]):
            of_extensions.append(f'    {{"VK_{guard}", {name}_sType}},\n')
    return "".join([
        HEAD, "static const struct feature features[] = {\n",
        *(f'    {{{name}_sType, "{name}", "{member.split(".")[-1]}", offsetof({name}, {member})}},\n'
          for name, members in rows.items() for member in members),
        "};\nstatic const struct extension_features features_of_extensions[] = {\n", *of_extensions, "};\n"])


def played(registry):
    """The parameters of each command of a device, for tests that play the driver."""
    return "".join([
        HEAD, """/* A command of the driver, as the test plays it: PLAYED(CmdSetEvent) { ... }, in the table that
 * PLAYED_COMMANDS names. The parameters have their names of the registry. */
#define PLAYED(name) PLAY_##name
#define PLAY(result, name, ...) \\
    static VKAPI_ATTR result VKAPI_CALL play_##name(__VA_ARGS__); \\
    __attribute__((constructor)) static void add_##name(void) { PLAYED_COMMANDS.name = play_##name; } \\
    static VKAPI_ATTR result VKAPI_CALL play_##name(__VA_ARGS__)
""",
        *(f"#define PLAY_{name} PLAY({command.returns}, {name}, {command.declaration})\n"
          for name, command in registry.commands.items()
          if command.parameters[0].type in ("VkDevice", "VkQueue", "VkCommandBuffer"))])


def constants(registry):
    """Yields the definition of each of CONSTANTS."""
    for declaration, values in CONSTANTS.items():
        members = {member: value for value, patterns in values.items()
                   for pattern in patterns.split()
                   for member in fnmatch.filter(registry.members_of(declaration.split()[0]), pattern)}
        yield f"\nconst {declaration} = {{\n" + "".join(
            f"    .{member} = {value},\n" for member, value in members.items()) + "};\n"


def stubs(registry, commands, rows):
    return "".join([
        HEAD, '#include "tests/null_driver/internal.h"\n',
        *(command.source() for command in commands), *constants(registry),
        "\nconst struct entry_point entry_points[] = {\n",
        *(f'    {{"vk{name}", (PFN_vkVoidFunction)entry_{target}, ENTRY_{target}, {level}, '
          f"{guard}}},\n" for level, name, target, guard in rows),
        "};\nconst size_t entry_point_count = COUNT_OF(entry_points);\n",
        "\nconst struct feature_row feature_rows[] = {\n", *feature_rows(registry),
        "};\nconst size_t feature_row_count = COUNT_OF(feature_rows);\n"])


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--registry", type=pathlib.Path, required=True, help="vk.xml")
    parser.add_argument("--out", type=pathlib.Path, required=True, help="folder to write to")
    arguments = parser.parse_args()
    registry = Registry(arguments.registry)
    commands, rows = read_commands(registry)
    arguments.out.mkdir(parents=True, exist_ok=True)
    (arguments.out / "generated.h").write_text(header(registry, commands))
    (arguments.out / "structures.h").write_text(structures(registry))
    (arguments.out / "device_features.h").write_text(features(registry))
    (arguments.out / "vulkan_commands.h").write_text(played(registry))
    (arguments.out / "stubs.c").write_text(stubs(registry, commands, rows))


if __name__ == "__main__":
    main()

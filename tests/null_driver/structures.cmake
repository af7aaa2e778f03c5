# SPDX-License-Identifier: Apache-2.0
# What is generated from the registry: the entry points of the null driver, the macros of tests/fixture/make.h,
# which the demo uses without the driver, and the parameters of commands that tests play.
set(generated ${PROJECT_BINARY_DIR}/tests/null_driver/generated)
add_custom_command(
    OUTPUT ${generated}/generated.h ${generated}/stubs.c ${generated}/structures.h ${generated}/device_features.h
        ${generated}/vulkan_commands.h
    COMMAND Python3::Interpreter -B ${CMAKE_CURRENT_LIST_DIR}/generate.py
        --registry ${ASSAY_REGISTRY_DIR}/vk.xml --out ${generated}
    DEPENDS ${CMAKE_CURRENT_LIST_DIR}/generate.py ${CMAKE_CURRENT_LIST_DIR}/../../vuid-tables/signatures.py
        ${ASSAY_REGISTRY_DIR}/vk.xml
    COMMENT "Generating the null driver's entry points"
    VERBATIM)

# For tests/fixture/make.h.
add_custom_target(generate_structures DEPENDS ${generated}/structures.h ${generated}/device_features.h)
add_library(vulkan_structures INTERFACE)
add_dependencies(vulkan_structures generate_structures)
target_include_directories(vulkan_structures INTERFACE ${generated} ${PROJECT_SOURCE_DIR})

# SPDX-License-Identifier: Apache-2.0
# ASSAY_PRECOMPILE: Vulkan's header is compiled once for each optimisation of libraries and of programs, because it takes
# a quarter of the time of most compilations. A source may then lack an include that it needs, and compile nevertheless:
# scripts/lint --includes finds it.

# Their options, such as those for processors, are not those of the precompiled header.
set(other_targets "^(assay_bvh_avx|assay_call_sites|precompiled_)")

file(CONFIGURE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/precompiled.c CONTENT "typedef int precompiled;\n")

# precompiled_for(RESULT IS_LIBRARY OPTIONS): the target that compiles the header for such targets. GCC takes no header
# that was compiled with another optimisation, or not as a library's.
function(precompiled_for result is_library options)
    set(name precompiled_program)
    if(is_library)
        set(name precompiled_library)
    endif()
    string(REGEX MATCH "-O[0-9]" optimisation "${options}")
    if(CMAKE_BUILD_TYPE STREQUAL "Debug") # all targets have that of the preset
        set(optimisation)
    endif()
    string(APPEND name "${optimisation}")
    if(NOT TARGET ${name})
        add_library(${name} OBJECT ${CMAKE_CURRENT_BINARY_DIR}/precompiled.c)
        target_link_libraries(${name} PRIVATE vulkan_deps)
        target_precompile_headers(${name} PRIVATE <vulkan/vulkan.h>)
        target_compile_options(${name} PRIVATE ${optimisation})
        set_target_properties(${name} PROPERTIES POSITION_INDEPENDENT_CODE ${is_library})
    endif()
    set(${result} ${name} PARENT_SCOPE)
endfunction()

# precompile_target(TARGET): has the sources of TARGET use the precompiled header, except for those that have options of
# their own, or that define what the system's headers have to see.
function(precompile_target target)
    get_target_property(type ${target} TYPE)
    get_target_property(is_library ${target} POSITION_INDEPENDENT_CODE)
    if(is_library OR type STREQUAL MODULE_LIBRARY)
        set(is_library ON)
    else()
        set(is_library OFF)
    endif()
    get_target_property(options ${target} COMPILE_OPTIONS)
    precompiled_for(precompiled ${is_library} "${options}")
    target_precompile_headers(${target} REUSE_FROM ${precompiled})
    target_link_libraries(${target} PRIVATE vulkan_deps) # where a target lacks it: the header needs its definitions
    get_target_property(folder ${target} SOURCE_DIR)
    get_target_property(sources ${target} SOURCES)
    foreach(source IN LISTS sources)
        cmake_path(ABSOLUTE_PATH source BASE_DIRECTORY ${folder})
        set(definition)
        if(EXISTS ${source})
            file(STRINGS ${source} definition REGEX "^#define _GNU_SOURCE" LIMIT_COUNT 1)
        endif()
        get_source_file_property(options ${source} TARGET_DIRECTORY ${target} COMPILE_OPTIONS)
        if(definition OR options)
            set_source_files_properties(${source} TARGET_DIRECTORY ${target} PROPERTIES SKIP_PRECOMPILE_HEADERS ON)
        endif()
    endforeach()
endfunction()

# precompile_folder(FOLDER): the targets of FOLDER and of all folders in it.
function(precompile_folder folder)
    get_directory_property(targets DIRECTORY ${folder} BUILDSYSTEM_TARGETS)
    foreach(target IN LISTS targets)
        get_target_property(type ${target} TYPE)
        if(type MATCHES "^(STATIC_LIBRARY|MODULE_LIBRARY|OBJECT_LIBRARY|EXECUTABLE)$" AND NOT target MATCHES ${other_targets})
            precompile_target(${target})
        endif()
    endforeach()
    get_directory_property(folders DIRECTORY ${folder} SUBDIRECTORIES)
    foreach(subfolder IN LISTS folders)
        precompile_folder(${subfolder})
    endforeach()
endfunction()
precompile_folder(${PROJECT_SOURCE_DIR})

# SPDX-License-Identifier: Apache-2.0
# What unit tests share, also those of a library that is built alone (src/bvh/).

if(NOT WIN32)
    find_package(PkgConfig REQUIRED)
    pkg_check_modules(cmocka REQUIRED IMPORTED_TARGET cmocka)
endif()

# Unit tests with their main function, and allocations that fail: a program takes what it uses.
add_library(test_unit STATIC
    ${CMAKE_CURRENT_LIST_DIR}/../fixture/scarce_memory.c ${CMAKE_CURRENT_LIST_DIR}/property.c
    ${CMAKE_CURRENT_LIST_DIR}/unit_test.c)
target_include_directories(test_unit PRIVATE ${CMAKE_CURRENT_LIST_DIR}/../..)
target_link_libraries(test_unit PUBLIC PkgConfig::cmocka PRIVATE vulkan_deps)

# quick_add(TARGET TEST...): scripts/test --quick and scripts/mutants build TARGET and run the tests.
# They need no driver but the null driver, and take seconds.
add_custom_target(quick_tests)
function(quick_add target)
    add_dependencies(quick_tests ${target})
    set_property(TEST ${ARGN} APPEND PROPERTY LABELS quick)
endfunction()

# not_for_each_change(TEST...): scripts/test --quick leaves out these quick tests, which take the longest. scripts/mutants
# and scripts/platforms run them.
function(not_for_each_change)
    set_property(TEST ${ARGN} APPEND PROPERTY LABELS not-each-change)
endfunction()

# tsan_add(TEST...): the thread sanitizer's runs have these tests alone, as it finds nothing in others:
# those with threads, and a few with one that take most locks of the layer, perhaps in a wrong order.
function(tsan_add)
    set_property(TEST ${ARGN} APPEND PROPERTY LABELS tsan)
endfunction()

# allocations_wrap(TARGET): allocations of TARGET go through tests/fixture/scarce_memory.h, so that the
# test can make them fail. TARGET links test_unit. Not on Windows: tests/windows/posix.c says why. There,
# tests of memory that runs out allocate as usual, and fail.
function(allocations_wrap target)
    if(WIN32)
        return()
    endif()
    target_link_options(${target} PRIVATE
        LINKER:--wrap=malloc LINKER:--wrap=calloc LINKER:--wrap=realloc LINKER:--wrap=aligned_alloc
        LINKER:--wrap=strdup LINKER:--wrap=free
        # The linker reads gcov after test_unit, and would no longer find the functions that gcov calls.
        LINKER:--undefined=__wrap_malloc)
    # Optimization at link time would bind the calls before they can be wrapped.
    set_target_properties(${target} PROPERTIES INTERPROCEDURAL_OPTIMIZATION OFF)
endfunction()

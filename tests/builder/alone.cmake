# SPDX-License-Identifier: Apache-2.0
# Builds src/bvh/ as a project of its own, from a copy of what it may include, and plays a test of it.
#
#     cmake -DSOURCE=... -DFOLDER=... [-DLAUNCHER=... -DPREFIX=...] -P alone.cmake

set(tree ${FOLDER}/tree)
foreach(path IN ITEMS src/bvh src/platform src/base/float_environment.h tests/unit tests/builder
        tests/fixture/scarce_memory.c tests/fixture/scarce_memory.h)
    cmake_path(GET path PARENT_PATH folder)
    file(COPY ${SOURCE}/${path} DESTINATION ${tree}/${folder})
endforeach()
foreach(command IN ITEMS
        "-S;${tree}/src/bvh;-B;${FOLDER}/build;-G;Ninja;-DCMAKE_BUILD_TYPE=Debug;-DCMAKE_C_FLAGS_DEBUG=-O0;-DCMAKE_C_COMPILER_LAUNCHER=${LAUNCHER};-DCMAKE_PREFIX_PATH=${PREFIX}"
        "--build;${FOLDER}/build;--target;builder_input_test")
    execute_process(COMMAND ${CMAKE_COMMAND} ${command} COMMAND_ERROR_IS_FATAL ANY)
endforeach()
execute_process(COMMAND ${FOLDER}/build/builder/builder_input_test COMMAND_ERROR_IS_FATAL ANY)

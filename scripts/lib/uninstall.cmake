# SPDX-License-Identifier: Apache-2.0
# The target `uninstall`. Included behind all other install rules, this file records the files of the
# last installation; install_manifest.txt does not serve, because cpack overwrites it. As a script
# (cmake -D RECORD=FILE -P) it removes the recorded files, and folders of Assay's own that are then empty.

if(NOT CMAKE_SCRIPT_MODE_FILE)
    set(record ${PROJECT_BINARY_DIR}/installed_files.txt)
    # cpack installs into a folder of that name.
    install(CODE "
        set(prefix \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}\")
        if(NOT prefix MATCHES /_CPack_Packages/)
            list(TRANSFORM CMAKE_INSTALL_MANIFEST_FILES PREPEND \"\$ENV{DESTDIR}\" OUTPUT_VARIABLE files)
            list(JOIN files \"\\n\" lines)
            file(WRITE \"${record}\" \"\${lines}\\n\")
        endif()")
    add_custom_target(uninstall
        COMMAND ${CMAKE_COMMAND} -D RECORD=${record} -P ${CMAKE_CURRENT_LIST_FILE}
        VERBATIM)
    return()
endif()

if(NOT EXISTS ${RECORD})
    message(FATAL_ERROR "Nothing was installed from this build folder: ${RECORD} does not exist.")
endif()
file(STRINGS ${RECORD} files)
foreach(file IN LISTS files)
    message(STATUS "Removing ${file}")
    file(REMOVE ${file})
    if(EXISTS ${file})
        message(FATAL_ERROR "${file} cannot be removed.")
    endif()
    cmake_path(GET file PARENT_PATH folder)
    while(folder MATCHES "/share/(doc/)?assay(/|$)")
        file(GLOB others "${folder}/*")
        if(others)
            break()
        endif()
        file(REMOVE_RECURSE ${folder})
        cmake_path(GET folder PARENT_PATH folder)
    endwhile()
endforeach()
file(REMOVE ${RECORD})

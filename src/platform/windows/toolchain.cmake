# SPDX-License-Identifier: Apache-2.0
# MinGW-w64 for Windows on x86-64, on Debian. Preset mingw uses it; scripts/windows installs what it
# needs, and puts libraries and headers into build/windows.
set(CMAKE_SYSTEM_NAME Windows)
set(CMAKE_SYSTEM_PROCESSOR x86_64)
set(CMAKE_C_COMPILER x86_64-w64-mingw32-gcc-posix)
set(CMAKE_RC_COMPILER x86_64-w64-mingw32-windres)

cmake_path(SET root NORMALIZE ${CMAKE_CURRENT_LIST_DIR}/../../..)
set(CMAKE_FIND_ROOT_PATH ${root}build/windows /usr/x86_64-w64-mingw32)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)

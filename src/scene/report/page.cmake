# SPDX-License-Identifier: Apache-2.0
# Joins page.html, page.css and page.js, and writes them as two arrays of C: what comes before the data, and after it.
# cmake -DFOLDER=... -DOUTPUT=... -P page.cmake
file(READ ${FOLDER}/page.html page)
file(READ ${FOLDER}/page.css css)
file(READ ${FOLDER}/page.js script)
string(REPLACE "@CSS@" "${css}" page "${page}")
string(REPLACE "@SCRIPT@" "${script}" page "${page}")
string(FIND "${page}" "@DATA@" at)
string(SUBSTRING "${page}" 0 ${at} before)
math(EXPR at "${at} + 6")
string(SUBSTRING "${page}" ${at} -1 after)
set(text "/* Made of page.html, page.css and page.js. */\n")
foreach(part IN ITEMS before after)
    string(HEX "${${part}}" hex)
    string(REGEX REPLACE "(..)" "0x\\1," hex "${hex}")
    string(APPEND text "extern const char page_${part}[];\nconst char page_${part}[] = {${hex}0};\n")
endforeach()
file(WRITE ${OUTPUT} "${text}")

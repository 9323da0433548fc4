# hds_hint_openusd_python(FOLDER...): pxrConfig.cmake asks for the exact Python that OpenUSD was built with, and CMake's
# search for it begins with the python3-config on PATH, which may belong to another one (pyenv, conda). The interpreter
# that the file names is asked instead; sets Python3_INCLUDE_DIR and Python3_LIBRARY where it answers.
function(hds_hint_openusd_python)
    find_file(config pxrConfig.cmake HINTS ${ARGN} ${CMAKE_PREFIX_PATH} PATH_SUFFIXES lib/cmake/pxr NO_CACHE)
    if(NOT config)
        return()
    endif()
    file(STRINGS "${config}" line REGEX "set\\(Python3_EXECUTABLE " LIMIT_COUNT 1)
    if(NOT line MATCHES "\\[\\[(.+)\\]\\]")
        return()
    endif()
    execute_process(
        COMMAND "${CMAKE_MATCH_1}" -c "import os, sysconfig as c
print(c.get_path('include'))
print(next(filter(os.path.exists, (os.path.join(c.get_config_var(f) or '', m or '', c.get_config_var('LDLIBRARY') or '')
      for f in ('LIBDIR', 'LIBPL') for m in ('', c.get_config_var('MULTIARCH')))), ''))"
        OUTPUT_VARIABLE answer ERROR_QUIET RESULT_VARIABLE status)
    if(status EQUAL 0 AND answer MATCHES "^([^\n]+)\n([^\n]+)\n")
        set(Python3_INCLUDE_DIR "${CMAKE_MATCH_1}" PARENT_SCOPE)
        set(Python3_LIBRARY "${CMAKE_MATCH_2}" PARENT_SCOPE)
    endif()
endfunction()

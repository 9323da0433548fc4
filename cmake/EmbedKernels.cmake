# Writes one generated .cpp with every file of kernels/ as a byte array (string literals have length
# limits on some compilers). Edits of a kernel rebuild it.

function(hds_embed_kernels output)
    file(GLOB_RECURSE kernels CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/kernels/*.cl"
         "${PROJECT_SOURCE_DIR}/kernels/*.clh" "${PROJECT_SOURCE_DIR}/kernels/*.h"
         "${PROJECT_SOURCE_DIR}/kernels/*.def")
    find_package(Python3 REQUIRED COMPONENTS Interpreter)
    add_custom_command(
        OUTPUT "${output}"
        COMMAND "${Python3_EXECUTABLE}" "${PROJECT_SOURCE_DIR}/cmake/embedKernels.py"
                "${PROJECT_SOURCE_DIR}/kernels" "${output}"
        DEPENDS ${kernels} "${PROJECT_SOURCE_DIR}/cmake/embedKernels.py"
        VERBATIM)
endfunction()

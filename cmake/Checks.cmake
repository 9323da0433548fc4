# Targets for developers: check-layers, check-format, check-tidy. The last two exist where their tool does.
find_package(Python3 REQUIRED COMPONENTS Interpreter)
add_custom_target(check-layers
    COMMAND "${Python3_EXECUTABLE}" "${PROJECT_SOURCE_DIR}/cmake/CheckLayers.py" "${PROJECT_SOURCE_DIR}"
    VERBATIM)

find_program(HDSTREAM_CLANG_FORMAT NAMES clang-format-14 clang-format)
if(HDSTREAM_CLANG_FORMAT)
    add_custom_target(check-format
        COMMAND "${Python3_EXECUTABLE}" "${PROJECT_SOURCE_DIR}/testenv/support/checkFormat.py"
                "${HDSTREAM_CLANG_FORMAT}"
        VERBATIM)
endif()

find_program(HDSTREAM_RUN_CLANG_TIDY NAMES run-clang-tidy-14 run-clang-tidy)
if(HDSTREAM_RUN_CLANG_TIDY)
    add_custom_target(check-tidy
        COMMAND "${HDSTREAM_RUN_CLANG_TIDY}" -quiet -p "${PROJECT_BINARY_DIR}"
                "${PROJECT_SOURCE_DIR}/(hdStream|testenv)/.*\\.cpp"
        VERBATIM)
endif()

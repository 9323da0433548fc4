# Finds OpenColorIO 2 as the target OpenColorIO::OpenColorIO: the library's own package configuration
# where there is one in a place CMake looks, else header and library (Debian 12 installs the
# configuration outside CMake's search path).
find_package(OpenColorIO 2 CONFIG QUIET)
if(NOT TARGET OpenColorIO::OpenColorIO)
    find_path(OpenColorIO_INCLUDE_DIR OpenColorIO/OpenColorIO.h)
    find_library(OpenColorIO_LIBRARY NAMES OpenColorIO)
    if(OpenColorIO_INCLUDE_DIR)
        file(STRINGS "${OpenColorIO_INCLUDE_DIR}/OpenColorIO/OpenColorABI.h" OpenColorIO_versionLine
             REGEX "define OCIO_VERSION_STR|define OCIO_VERSION +\"")
        string(REGEX MATCH "[0-9]+\\.[0-9]+\\.[0-9]+" OpenColorIO_VERSION "${OpenColorIO_versionLine}")
    endif()
    if(OpenColorIO_INCLUDE_DIR AND OpenColorIO_LIBRARY)
        add_library(OpenColorIO::OpenColorIO UNKNOWN IMPORTED)
        set_target_properties(OpenColorIO::OpenColorIO PROPERTIES
            IMPORTED_LOCATION "${OpenColorIO_LIBRARY}"
            INTERFACE_INCLUDE_DIRECTORIES "${OpenColorIO_INCLUDE_DIR}")
    endif()
endif()
include(FindPackageHandleStandardArgs)
if(OpenColorIO_CONFIG)
    find_package_handle_standard_args(OpenColorIO CONFIG_MODE)
else()
    find_package_handle_standard_args(OpenColorIO
        REQUIRED_VARS OpenColorIO_LIBRARY OpenColorIO_INCLUDE_DIR VERSION_VAR OpenColorIO_VERSION)
endif()

# Finds OpenVDB as the target OpenVDB::openvdb: header and library. OpenVDB's own module asks for
# parts of Boost that nobody here links.
find_path(OpenVDB_INCLUDE_DIR openvdb/openvdb.h)
find_library(OpenVDB_LIBRARY NAMES openvdb)
find_path(OpenVDB_IMATH_DIR Imath/half.h)
find_library(OpenVDB_IMATH_LIBRARY NAMES Imath Imath-3_1)
if(OpenVDB_INCLUDE_DIR)
    file(STRINGS "${OpenVDB_INCLUDE_DIR}/openvdb/version.h" OpenVDB_versionLines
         REGEX "define OPENVDB_LIBRARY_(MAJOR|MINOR)_VERSION_NUMBER")
    string(REGEX REPLACE ".*MAJOR_VERSION_NUMBER ([0-9]+).*MINOR_VERSION_NUMBER ([0-9]+).*" "\\1.\\2"
           OpenVDB_VERSION "${OpenVDB_versionLines}")
endif()
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenVDB
    REQUIRED_VARS OpenVDB_LIBRARY OpenVDB_INCLUDE_DIR VERSION_VAR OpenVDB_VERSION)
if(OpenVDB_FOUND AND NOT TARGET OpenVDB::openvdb)
    add_library(OpenVDB::openvdb UNKNOWN IMPORTED)
    set(OpenVDB_includes "${OpenVDB_INCLUDE_DIR}")
    if(OpenVDB_IMATH_DIR)
        list(APPEND OpenVDB_includes "${OpenVDB_IMATH_DIR}" "${OpenVDB_IMATH_DIR}/Imath")
    endif()
    set(OpenVDB_libraries TBB::tbb)
    if(OpenVDB_IMATH_LIBRARY) # halves are Imath's
        list(APPEND OpenVDB_libraries "${OpenVDB_IMATH_LIBRARY}")
    endif()
    list(REMOVE_DUPLICATES OpenVDB_includes)
    set_target_properties(OpenVDB::openvdb PROPERTIES
        IMPORTED_LOCATION "${OpenVDB_LIBRARY}" INTERFACE_INCLUDE_DIRECTORIES "${OpenVDB_includes}"
        INTERFACE_LINK_LIBRARIES "${OpenVDB_libraries}")
endif()

# For files that include it: its templates share their static members with the library, so these must not be hidden.
set(OpenVDB_COMPILE_OPTIONS "-fvisibility=default;-fno-visibility-inlines-hidden")

# What programs that embed the core install: component sdk (docs/packaging.md).
#   hds_install_sdk(HEADER layers...): HEADER and what it includes of ours, the libraries of the layers,
#   and the CMake package hdStream with the target hdStream::session.
include(CMakePackageConfigHelpers)
include(GNUInstallDirs)

# Appends to the list RESULT the header and those of ours that it includes, relative to the source folder.
function(_hds_included_headers result header)
    set(headers ${${result}})
    if(NOT header IN_LIST headers)
        list(APPEND headers "${header}")
        set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/${header}")
        file(STRINGS "${PROJECT_SOURCE_DIR}/${header}" lines REGEX "^ *# *include \"")
        foreach(line IN LISTS lines)
            string(REGEX REPLACE ".*\"(.*)\".*" "\\1" included "${line}")
            if(NOT EXISTS "${PROJECT_SOURCE_DIR}/${included}")
                set(included "kernels/${included}")
            endif()
            _hds_included_headers(headers "${included}")
        endforeach()
    endif()
    set(${result} "${headers}" PARENT_SCOPE)
endfunction()

function(hds_install_sdk header)
    # A folder of its own, since what host and device share is included as "kernels/..." and "shared/...".
    set(include "${CMAKE_INSTALL_INCLUDEDIR}/hdStreamCore")
    set(headers "")
    _hds_included_headers(headers "${header}")
    foreach(file IN LISTS headers)
        get_filename_component(folder "${file}" DIRECTORY)
        install(FILES "${PROJECT_SOURCE_DIR}/${file}" DESTINATION "${include}/${folder}" COMPONENT sdk)
    endforeach()

    set(package "${CMAKE_INSTALL_LIBDIR}/cmake/hdStream")
    set(targets hdsFlags)
    foreach(layer IN LISTS ARGN)
        hds_layer_target(target "${layer}")
        set_target_properties(${target} PROPERTIES EXPORT_NAME "${layer}")
        list(APPEND targets ${target})
    endforeach()
    set_target_properties(hdsFlags PROPERTIES EXPORT_NAME flags)
    install(TARGETS ${targets} EXPORT hdStreamTargets COMPONENT sdk
            ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}"
            INCLUDES DESTINATION "${include}" "${include}/kernels")
    install(EXPORT hdStreamTargets NAMESPACE hdStream:: DESTINATION "${package}" COMPONENT sdk)
    configure_package_config_file("${PROJECT_SOURCE_DIR}/cmake/hdStreamConfig.cmake.in"
        "${PROJECT_BINARY_DIR}/hdStreamConfig.cmake" INSTALL_DESTINATION "${package}"
        NO_SET_AND_CHECK_MACRO NO_CHECK_REQUIRED_COMPONENTS_MACRO)
    # Before 1.0 every minor version may change the interface.
    write_basic_package_version_file("${PROJECT_BINARY_DIR}/hdStreamConfigVersion.cmake"
        COMPATIBILITY SameMinorVersion)
    install(FILES "${PROJECT_BINARY_DIR}/hdStreamConfig.cmake" "${PROJECT_BINARY_DIR}/hdStreamConfigVersion.cmake"
                  "${PROJECT_SOURCE_DIR}/cmake/FindOpenImageIO.cmake"
                  "${PROJECT_SOURCE_DIR}/cmake/FindOpenColorIO.cmake"
                  "${PROJECT_SOURCE_DIR}/cmake/FindOpenSubdiv.cmake"
                  "${PROJECT_SOURCE_DIR}/cmake/FindOpenVDB.cmake"
            DESTINATION "${package}" COMPONENT sdk)
    install(FILES "${PROJECT_SOURCE_DIR}/LICENSE" DESTINATION "${CMAKE_INSTALL_DOCDIR}" COMPONENT sdk)
endfunction()

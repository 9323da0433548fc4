# The program hdstreamCompileKernels, which compiles kernels for processes that render (docs/device.md).
# They look for it beside the library or program that the core is linked into.
add_executable(hdstreamCompileKernels "${PROJECT_SOURCE_DIR}/hdStream/device/compiler/compileKernels.cpp")
target_link_libraries(hdstreamCompileKernels PRIVATE hdsDevice)
set_target_properties(hdstreamCompileKernels PROPERTIES RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/bin")
# It starts in a moment: of the libraries that the layers are linked with it needs the loader of OpenCL.
target_link_options(hdstreamCompileKernels PRIVATE -Wl,--as-needed)

install(TARGETS hdstreamCompileKernels RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}" COMPONENT sdk)

# A link in the build tree; made before there is anything behind it.
function(hds_put_kernel_compiler_beside target folder)
    file(MAKE_DIRECTORY "${folder}")
    get_target_property(place hdstreamCompileKernels RUNTIME_OUTPUT_DIRECTORY)
    file(CREATE_LINK "${place}/hdstreamCompileKernels" "${folder}/hdstreamCompileKernels" SYMBOLIC)
    add_dependencies(${target} hdstreamCompileKernels)
endfunction()

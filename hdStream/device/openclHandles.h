// SPDX-License-Identifier: Apache-2.0
// OpenCL objects behind Device; private to the device layer.
#pragma once

#include "hdStream/device/device.h"
#include "hdStream/device/keptPrograms.h"

// Drivers of 1.2 will do: what came later is called where the device says that it has it.
#define CL_TARGET_OPENCL_VERSION 200
#define CL_USE_DEPRECATED_OPENCL_1_2_APIS
#include <CL/cl.h>

namespace hds {

struct Device::Handles {
    cl_platform_id platform = nullptr;
    cl_device_id device = nullptr;
    cl_context context = nullptr;
    cl_command_queue queue = nullptr;
    std::unique_ptr<KeptPrograms> programs; ///< null: it keeps none
};

/// The name of an OpenCL error code.
const char* OpenClErrorName(cl_int code);

/// \throws Error "what: CL_NAME (code)" unless the code is CL_SUCCESS.
void CheckOpenCl(cl_int code, const std::string& what);

} // namespace hds

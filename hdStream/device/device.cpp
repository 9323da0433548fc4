// SPDX-License-Identifier: Apache-2.0
#include "hdStream/device/device.h"

#include "hdStream/base/letters.h"
#include "hdStream/device/deviceOrder.h"
#include "hdStream/device/kernelCompilers.h"
#include "hdStream/device/openclHandles.h"
#include "hdStream/device/poclCache.h"

#include <algorithm>
#include <chrono>
#include <mutex>
#include <thread>
#include <tuple>
#include <utility>

namespace hds {

const char* OpenClErrorName(cl_int code) {
    switch (code) {
    case CL_DEVICE_NOT_FOUND:
        return "CL_DEVICE_NOT_FOUND";
    case CL_DEVICE_NOT_AVAILABLE:
        return "CL_DEVICE_NOT_AVAILABLE";
    case CL_COMPILER_NOT_AVAILABLE:
        return "CL_COMPILER_NOT_AVAILABLE";
    case CL_MEM_OBJECT_ALLOCATION_FAILURE:
        return "CL_MEM_OBJECT_ALLOCATION_FAILURE";
    case CL_OUT_OF_RESOURCES:
        return "CL_OUT_OF_RESOURCES";
    case CL_OUT_OF_HOST_MEMORY:
        return "CL_OUT_OF_HOST_MEMORY";
    case CL_BUILD_PROGRAM_FAILURE:
        return "CL_BUILD_PROGRAM_FAILURE";
    case CL_INVALID_VALUE:
        return "CL_INVALID_VALUE";
    case CL_INVALID_BINARY:
        return "CL_INVALID_BINARY";
    case CL_INVALID_KERNEL_NAME:
        return "CL_INVALID_KERNEL_NAME";
    case CL_INVALID_KERNEL_ARGS:
        return "CL_INVALID_KERNEL_ARGS";
    case CL_INVALID_ARG_INDEX:
        return "CL_INVALID_ARG_INDEX";
    case CL_INVALID_ARG_SIZE:
        return "CL_INVALID_ARG_SIZE";
    case CL_INVALID_WORK_GROUP_SIZE:
        return "CL_INVALID_WORK_GROUP_SIZE";
    case CL_INVALID_BUFFER_SIZE:
        return "CL_INVALID_BUFFER_SIZE";
    default:
        return "OpenCL error";
    }
}

void CheckOpenCl(cl_int code, const std::string& what) {
    if (code != CL_SUCCESS) {
        throw Error(what + ": " + OpenClErrorName(code) + " (" + std::to_string(code) + ")");
    }
}

struct FoundDevice {
    cl_platform_id platform;
    cl_device_id device;
    DeviceProperties properties;
};

namespace {

std::string DeviceString(cl_device_id device, cl_device_info key) {
    std::size_t bytes = 0;
    if (clGetDeviceInfo(device, key, 0, nullptr, &bytes) != CL_SUCCESS || bytes == 0) {
        return {};
    }
    std::string text(bytes, '\0');
    clGetDeviceInfo(device, key, bytes, text.data(), nullptr);
    text.resize(bytes - 1);
    return text;
}

template <typename T>
T DeviceValue(cl_device_id device, cl_device_info key) {
    T value{};
    clGetDeviceInfo(device, key, sizeof(value), &value, nullptr);
    return value;
}

std::string PlatformName(cl_platform_id platform) {
    std::size_t bytes = 0;
    if (clGetPlatformInfo(platform, CL_PLATFORM_NAME, 0, nullptr, &bytes) != CL_SUCCESS ||
        bytes == 0) {
        return {};
    }
    std::string text(bytes, '\0');
    clGetPlatformInfo(platform, CL_PLATFORM_NAME, bytes, text.data(), nullptr);
    text.resize(bytes - 1);
    return text;
}

std::vector<FoundDevice> FindDevices() {
    ReadyPoclEnvironment();
    std::vector<FoundDevice> found;
    cl_uint numPlatforms = 0;
    if (clGetPlatformIDs(0, nullptr, &numPlatforms) != CL_SUCCESS) {
        return found;
    }
    std::vector<cl_platform_id> platforms(numPlatforms);
    clGetPlatformIDs(numPlatforms, platforms.data(), nullptr);
    for (cl_platform_id platform : platforms) {
        cl_uint numDevices = 0;
        if (clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 0, nullptr, &numDevices) != CL_SUCCESS) {
            continue;
        }
        std::vector<cl_device_id> devices(numDevices);
        clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, numDevices, devices.data(), nullptr);
        for (cl_device_id device : devices) {
            DeviceProperties properties;
            properties.name = DeviceString(device, CL_DEVICE_NAME);
            properties.platform = PlatformName(platform);
            properties.version = DeviceString(device, CL_DEVICE_VERSION);
            properties.driverVersion = DeviceString(device, CL_DRIVER_VERSION);
            properties.memoryBytes = DeviceValue<cl_ulong>(device, CL_DEVICE_GLOBAL_MEM_SIZE);
            properties.maxAllocationBytes =
                DeviceValue<cl_ulong>(device, CL_DEVICE_MAX_MEM_ALLOC_SIZE);
            properties.computeUnits = DeviceValue<cl_uint>(device, CL_DEVICE_MAX_COMPUTE_UNITS);
            properties.isCpu =
                (DeviceValue<cl_device_type>(device, CL_DEVICE_TYPE) & CL_DEVICE_TYPE_CPU) != 0;
            // Devices of 1.2 do not know the question, which leaves the answer at 0.
            properties.sharesBuffers =
                properties.isCpu &&
                (DeviceValue<cl_device_svm_capabilities>(device, CL_DEVICE_SVM_CAPABILITIES) &
                 CL_DEVICE_SVM_FINE_GRAIN_BUFFER) != 0;
            properties.hasSlowBinaries = properties.platform == kPoclPlatform;
            properties.roundsWhenAsked =
                !properties.isCpu &&
                (DeviceValue<cl_device_fp_config>(device, CL_DEVICE_SINGLE_FP_CONFIG) &
                 CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT) != 0;
            found.push_back({platform, device, properties});
        }
    }
    std::stable_sort(found.begin(), found.end(), [](const FoundDevice& a, const FoundDevice& b) {
        return ComesBefore(a.properties, b.properties);
    });
    return found;
}

bool ContainsIgnoringCase(const std::string& text, const std::string& part) {
    const auto equal = [](char a, char b) { return LowerLetter(a) == LowerLetter(b); };
    return std::search(text.begin(), text.end(), part.begin(), part.end(), equal) != text.end();
}

FoundDevice ChooseDevice(const std::vector<FoundDevice>& found, const std::string& name) {
    if (found.empty()) {
        throw Error("no OpenCL device: install a driver (on Debian and Ubuntu: pocl-opencl-icd)");
    }
    if (name.empty()) {
        const auto gpu = std::find_if(found.begin(), found.end(), [](const FoundDevice& candidate) {
            return !candidate.properties.isCpu;
        });
        return gpu != found.end() ? *gpu : found.front();
    }
    const auto match = std::find_if(found.begin(), found.end(), [&](const FoundDevice& candidate) {
        return ContainsIgnoringCase(candidate.properties.name, name) ||
               ContainsIgnoringCase(candidate.properties.platform, name);
    });
    if (match == found.end()) {
        throw Error("--device " + name +
                        ": no OpenCL device has this in its name (see `hdstream devices`)",
                    ErrorKind::Usage);
    }
    return *match;
}

/// Waits until nobody holds a context but who asks. PoCL's threads let go of a queue, and with it
/// of the context, after they have woken who waits for its commands. Who lets go last frees what
/// LLVM has made; on such a thread that would go on while the process ends, and LLVM's globals with
/// it. Nobody else should hold one; if somebody does, looks are numbered. Seconds would not do:
/// where other processes take the machine, or this one is stopped, they pass while no thread gets
/// on.
void AwaitLastUser(cl_context context) {
    constexpr int kMaxLooks = 30'000; // three seconds or so where nothing else runs
    const auto isHeld = [context] {
        cl_uint count = 0;
        const cl_int code =
            clGetContextInfo(context, CL_CONTEXT_REFERENCE_COUNT, sizeof(count), &count, nullptr);
        return code == CL_SUCCESS && count > 1;
    };
    for (int look = 0; look < kMaxLooks && isHeld(); ++look) {
        std::this_thread::sleep_for(std::chrono::microseconds(50));
    }
}

} // namespace

std::vector<DeviceProperties> ListDeviceProperties() {
    std::vector<DeviceProperties> properties;
    for (const FoundDevice& found : FindDevices()) {
        properties.push_back(found.properties);
    }
    return properties;
}

Device::Device() : _handles(std::make_unique<Handles>()) {}

namespace {

/// Handles that nobody uses, one for each device at most. They live as long as the process: the
/// driver's own globals may be gone before ours are.
struct IdleHandles {
    std::mutex mutex;
    std::vector<std::unique_ptr<Device::Handles>> handles;

    static IdleHandles& Instance() {
        static auto* const instance = new IdleHandles;
        return *instance;
    }

    /// Null: none of this device.
    std::unique_ptr<Device::Handles> Take(cl_device_id device) {
        const std::lock_guard<std::mutex> lock(mutex);
        const auto found = std::find_if(handles.begin(), handles.end(), [&](const auto& candidate) {
            return candidate->device == device;
        });
        if (found == handles.end()) {
            return nullptr;
        }
        std::unique_ptr<Device::Handles> taken = std::move(*found);
        handles.erase(found);
        return taken;
    }
};

} // namespace

bool Device::LeaveHandles() {
    IdleHandles& idle = IdleHandles::Instance();
    const std::lock_guard<std::mutex> lock(idle.mutex);
    const bool hasOne =
        std::any_of(idle.handles.begin(), idle.handles.end(), [this](const auto& candidate) {
            return candidate->device == _handles->device;
        });
    if (!hasOne) {
        idle.handles.push_back(std::move(_handles));
    }
    return !hasOne;
}

void Device::LeaveNothing() {
    _leavesHandles = false;
}

Device::~Device() {
    if (_handles->queue != nullptr) {
        // What an error has left behind still runs.
        const bool isWell = clFinish(_handles->queue) == CL_SUCCESS;
        if (_handles->programs && _leavesHandles && isWell && LeaveHandles()) {
            return;
        }
        _handles->programs.reset();
        clReleaseCommandQueue(_handles->queue);
    }
    if (_handles->context != nullptr) {
        if (_properties.platform == kPoclPlatform) {
            AwaitLastUser(_handles->context);
        }
        clReleaseContext(_handles->context);
    }
}

DeviceProperties FindDevice(const std::string& name) {
    return ChooseDevice(FindDevices(), name).properties;
}

std::shared_ptr<Device> Device::Create(const std::string& name) {
    return Open(ChooseDevice(FindDevices(), name));
}

std::shared_ptr<Device> Device::Reuse(const std::string& name) {
    return Open(ChooseDevice(FindDevices(), name), true);
}

std::shared_ptr<Device> Device::Create(const DeviceProperties& properties) {
    const auto texts = [](const DeviceProperties& p) {
        return std::tie(p.platform, p.name, p.version, p.driverVersion);
    };
    for (const FoundDevice& found : FindDevices()) {
        if (texts(found.properties) == texts(properties)) {
            return Open(found);
        }
    }
    throw Error("no OpenCL device " + properties.name);
}

void Device::SetCompilers(std::unique_ptr<KernelCompilers> compilers) {
    _compilers = std::move(compilers);
}

std::shared_ptr<Device> Device::Open(const FoundDevice& chosen, bool mayReuse) {
    std::shared_ptr<Device> device(new Device);
    device->_properties = chosen.properties;
    const bool keepsPrograms = mayReuse && chosen.properties.platform == kPoclPlatform;
    if (keepsPrograms) {
        if (std::unique_ptr<Handles> idle = IdleHandles::Instance().Take(chosen.device)) {
            device->_handles = std::move(idle);
            return device;
        }
        device->_handles->programs = std::make_unique<KeptPrograms>();
    }
    Handles& handles = *device->_handles;
    handles.platform = chosen.platform;
    handles.device = chosen.device;
    cl_int code = CL_SUCCESS;
    handles.context = clCreateContext(nullptr, 1, &chosen.device, nullptr, nullptr, &code);
    CheckOpenCl(code, "creating a context on " + chosen.properties.name);
    handles.queue = clCreateCommandQueue(handles.context, chosen.device, 0, &code);
    CheckOpenCl(code, "creating a queue on " + chosen.properties.name);
    return device;
}

void Device::Finish() {
    if (!_isIdle) {
        CheckOpenCl(clFinish(_handles->queue), "running kernels on " + _properties.name);
        _isIdle = true;
    }
}

void Device::CountAllocation(std::int64_t bytes) {
    _allocatedBytes =
        static_cast<std::uint64_t>(static_cast<std::int64_t>(_allocatedBytes) + bytes);
    _peakBytes = std::max(_peakBytes, _allocatedBytes);
}

} // namespace hds

// SPDX-License-Identifier: Apache-2.0
#include "hdStream/device/program.h"

#include "hdStream/base/hash.h"
#include "hdStream/device/openclHandles.h"

#include "kernels/shared/material.h"
#include "kernels/shared/residency.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace hds {

namespace {

constexpr const char* kBinaryKind = "kernel";
/// Raised when the way programs are built changes.
constexpr std::uint64_t kKernelAbi = 1;

cl_program AsProgram(void* program) {
    return static_cast<cl_program>(program);
}

std::string BuildLog(cl_program program, cl_device_id device) {
    std::size_t bytes = 0;
    clGetProgramBuildInfo(program, device, CL_PROGRAM_BUILD_LOG, 0, nullptr, &bytes);
    std::string log(bytes, '\0');
    clGetProgramBuildInfo(program, device, CL_PROGRAM_BUILD_LOG, bytes, log.data(), nullptr);
    return log;
}

/// Adds the default of each define that is not said. \pre all that is said is in the table.
ProgramDefines Complete(const ProgramDefines& said) {
    ProgramDefines defines;
#define HDS_FEATURE(type, member, macro, off, on, needs, doc) \
    defines[#macro] = std::to_string(static_cast<std::uint32_t>(on));
#define HDS_VARIANT(member, macro, needs, doc) defines[#macro] = "0";
#define HDS_TUNABLE(macro, value, doc) defines[#macro] = #value;
#include "kernels/shared/features.def"
    for (const auto& [name, value] : said) {
        const auto known = defines.find(name);
        HDS_VERIFY(known != defines.end(), name + " is not in kernels/shared/features.def");
        known->second = value;
    }
    return defines;
}

std::string OptionsOf(const ProgramDefines& said) {
    std::string options = "-cl-std=CL1.2";
    for (const auto& [name, value] : Complete(said)) {
        options.append(" -D").append(name).append("=").append(value);
    }
    return options;
}

std::string BinaryKey(const Device& device, const std::string& source, const std::string& options) {
    const DeviceProperties& properties = device.Properties();
    Hasher hasher;
    hasher.Append(kKernelAbi);
    for (const std::string* part : {&source, &options, &properties.platform, &properties.name,
                                    &properties.version, &properties.driverVersion}) {
        hasher.Append(std::string_view(*part));
    }
    return hasher.Hex();
}

} // namespace

Program::Program(std::shared_ptr<Device> device, const std::string& root,
                 const ProgramDefines& defines, Store* store, const std::string* text)
    : _device(std::move(device)), _root(root) {
    const auto start = std::chrono::steady_clock::now();
    const std::string source = ExpandKernelSource(root, text);
    const std::string options = OptionsOf(defines);
    const std::string key = BinaryKey(*_device, source, options);
    _isFromCache = BuildFromCache(store, key, options);
    if (!_isFromCache) {
        BuildFromSource(source, options);
        _unsavedKey = key;
        if (!_device->Properties().hasSlowBinaries) {
            SaveBinary(store);
        }
    }
    _buildSeconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

bool Program::IsInStore(const Device& device, const std::string& root,
                        const ProgramDefines& defines, const Store& store) {
    return store.Contains(kBinaryKind,
                          BinaryKey(device, ExpandKernelSource(root), OptionsOf(defines)));
}

Program::~Program() {
    if (_program != nullptr) {
        clReleaseProgram(AsProgram(_program));
    }
}

bool Program::BuildFromCache(Store* store, const std::string& key, const std::string& options) {
    if (store == nullptr) {
        return false;
    }
    const auto binary = store->Load(kBinaryKind, key);
    if (!binary) {
        return false;
    }
    const Device::Handles& handles = _device->GetHandles();
    const std::size_t bytes = binary->size();
    const unsigned char* data = binary->data();
    cl_int status = CL_SUCCESS;
    cl_int code = CL_SUCCESS;
    cl_program program = clCreateProgramWithBinary(handles.context, 1, &handles.device, &bytes,
                                                   &data, &status, &code);
    if (code != CL_SUCCESS) {
        return false;
    }
    if (clBuildProgram(program, 1, &handles.device, options.c_str(), nullptr, nullptr) !=
        CL_SUCCESS) {
        clReleaseProgram(program);
        return false;
    }
    _program = program;
    return true;
}

void Program::BuildFromSource(const std::string& source, const std::string& options) {
    const Device::Handles& handles = _device->GetHandles();
    const char* textPointer = source.c_str();
    const std::size_t textBytes = source.size();
    cl_int code = CL_SUCCESS;
    cl_program program =
        clCreateProgramWithSource(handles.context, 1, &textPointer, &textBytes, &code);
    CheckOpenCl(code, "creating program " + _root);
    code = clBuildProgram(program, 1, &handles.device, options.c_str(), nullptr, nullptr);
    if (code != CL_SUCCESS) {
        const std::string log = BuildLog(program, handles.device);
        clReleaseProgram(program);
        throw Error("building " + _root + " for " + _device->Properties().name + " with " +
                    options + ": " + OpenClErrorName(code) + "\n" + log);
    }
    _program = program;
}

void Program::SaveBinary(Store* store) {
    const std::string key = std::exchange(_unsavedKey, {});
    // A store that keeps nothing must not ask for what the driver may have to compile.
    if (store == nullptr || !store->IsEnabled() || key.empty()) {
        return;
    }
    std::size_t bytes = 0;
    if (clGetProgramInfo(AsProgram(_program), CL_PROGRAM_BINARY_SIZES, sizeof(bytes), &bytes,
                         nullptr) != CL_SUCCESS ||
        bytes == 0) {
        return;
    }
    std::vector<unsigned char> binary(bytes);
    unsigned char* pointer = binary.data();
    if (clGetProgramInfo(AsProgram(_program), CL_PROGRAM_BINARIES, sizeof(pointer), &pointer,
                         nullptr) == CL_SUCCESS) {
        store->Save(kBinaryKind, key, binary.data(), binary.size());
    }
}

Kernel Program::GetKernel(const std::string& name) const {
    cl_int code = CL_SUCCESS;
    cl_kernel kernel = clCreateKernel(AsProgram(_program), name.c_str(), &code);
    CheckOpenCl(code, "kernel " + name + " of " + _root);
    return {_device, kernel, name};
}

Kernel::Kernel(std::shared_ptr<Device> device, void* kernel, std::string name)
    : _device(std::move(device)), _kernel(kernel), _name(std::move(name)) {
    cl_uint count = 0;
    CheckOpenCl(clGetKernelInfo(static_cast<cl_kernel>(_kernel), CL_KERNEL_NUM_ARGS, sizeof(count),
                                &count, nullptr),
                "arguments of kernel " + _name);
    _isSet.resize(count);
}

Kernel::~Kernel() {
    if (_kernel != nullptr) {
        clReleaseKernel(static_cast<cl_kernel>(_kernel));
    }
}

Kernel::Kernel(Kernel&& other) noexcept {
    *this = std::move(other);
}

Kernel& Kernel::operator=(Kernel&& other) noexcept {
    std::swap(_device, other._device);
    std::swap(_kernel, other._kernel);
    std::swap(_name, other._name);
    std::swap(_isSet, other._isSet);
    std::swap(_numKept, other._numKept);
    std::swap(_itemsPerWorkItem, other._itemsPerWorkItem);
    std::swap(_groupSize, other._groupSize);
    return *this;
}

void Kernel::ForgetFrom(unsigned index) {
    std::fill(_isSet.begin() + std::min<std::size_t>(index, _isSet.size()), _isSet.end(), false);
}

void Kernel::SetBuffer(unsigned index, const Buffer& buffer) {
    HDS_VERIFY(buffer.IsValid(), _name + " argument " + std::to_string(index));
    cl_mem memory = static_cast<cl_mem>(buffer.Memory());
    SetBytes(index, &memory, sizeof(memory));
}

void Kernel::SetBytes(unsigned index, const void* data, std::size_t bytes) {
    HDS_VERIFY(index < _isSet.size(), "kernel " + _name + " takes " +
                                          std::to_string(_isSet.size()) +
                                          " arguments, and gets one more");
    CheckOpenCl(clSetKernelArg(static_cast<cl_kernel>(_kernel), index, bytes, data),
                _name + " argument " + std::to_string(index));
    _isSet[index] = true;
}

void Kernel::SetItemsPerWorkItem(std::uint32_t length) {
    _itemsPerWorkItem = length;
    _groupSize = length > 1 ? 1 : kGroupSize;
}

void Kernel::Enqueue(std::size_t numItems) {
    if (numItems == 0) {
        return;
    }
    const auto missing = std::find(_isSet.begin(), _isSet.end(), false);
    HDS_VERIFY(missing == _isSet.end(), "kernel " + _name + " is not given argument " +
                                            std::to_string(missing - _isSet.begin()) + " of " +
                                            std::to_string(_isSet.size()));
    const std::size_t numWorkItems = (numItems + _itemsPerWorkItem - 1) / _itemsPerWorkItem;
    const std::size_t global = (numWorkItems + _groupSize - 1) / _groupSize * _groupSize;
    CheckOpenCl(clEnqueueNDRangeKernel(_device->GetHandles().queue, static_cast<cl_kernel>(_kernel),
                                       1, nullptr, &global, &_groupSize, 0, nullptr, nullptr),
                "launching " + _name);
    _device->_isIdle = false;
}

} // namespace hds

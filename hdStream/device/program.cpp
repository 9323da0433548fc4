// SPDX-License-Identifier: Apache-2.0
#include "hdStream/device/program.h"

#include "hdStream/device/kernelCompilers.h"
#include "hdStream/device/kernelSource.h"
#include "hdStream/device/openclHandles.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <utility>

namespace hds {

namespace {

constexpr const char* kBinaryKind = "kernel";

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

} // namespace

Program::Program(std::shared_ptr<Device> device, const ProgramSource& source, Store* store)
    : _device(std::move(device)), _root(source.root), _key(source.key) {
    const auto start = std::chrono::steady_clock::now();
    _isFromCache = TakeKept(source, store) || BuildFromStore(source, store);
    if (!_isFromCache && !BuildFromCompilers(source, store)) {
        BuildFromSource(source);
        _unsavedKey = source.key;
        if (!_device->Properties().hasSlowBinaries) {
            SaveBinary(store);
        }
    }
    _buildSeconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

Program::Program(const std::shared_ptr<Device>& device, const std::string& root,
                 const ProgramDefines& defines, Store* store, const std::string* text)
    : Program(device, MakeProgramSource(device->Properties(), root, defines, text), store) {}

bool Program::IsInStore(const ProgramSource& source, const Store& store) {
    return store.Contains(kBinaryKind, source.key);
}

void Program::Announce(const Device& device, const std::vector<ProgramSource>& sources,
                       const Store* store) {
    KernelCompilers* compilers = device.Compilers();
    if (compilers == nullptr || store == nullptr || !compilers->CanCompile()) {
        return;
    }
    std::vector<ProgramSource> missing;
    std::copy_if(sources.begin(), sources.end(), std::back_inserter(missing),
                 [&](const ProgramSource& source) { return !IsInStore(source, *store); });
    if (!missing.empty()) {
        compilers->Begin(std::move(missing));
    }
}

Program::~Program() {
    if (_program == nullptr) {
        return;
    }
    if (KeptPrograms* kept = _device->GetHandles().programs.get()) {
        kept->Keep(std::move(_key), _program);
    } else {
        clReleaseProgram(AsProgram(_program));
    }
}

/// What a store lacks and wants is built as if nothing were kept: it is compiled by other
/// processes, and saved.
bool Program::TakeKept(const ProgramSource& source, const Store* store) {
    KeptPrograms* kept = _device->GetHandles().programs.get();
    if (kept == nullptr || (store != nullptr && store->IsWriting() && !IsInStore(source, *store))) {
        return false;
    }
    _program = kept->Take(source.key);
    return _program != nullptr;
}

bool Program::BuildFromStore(const ProgramSource& source, Store* store) {
    if (store == nullptr) {
        return false;
    }
    const std::vector<unsigned char> binary = StoredBinary(source, store);
    return !binary.empty() && BuildFromBinary(source, binary.data(), binary.size());
}

std::vector<unsigned char> Program::StoredBinary(const ProgramSource& source, Store* store) {
    return store->Load(kBinaryKind, source.key).value_or(std::vector<unsigned char>());
}

bool Program::BuildFromCompilers(const ProgramSource& source, const Store* store) {
    KernelCompilers* compilers = store != nullptr ? _device->Compilers() : nullptr;
    if (compilers == nullptr) {
        return false;
    }
    const std::vector<unsigned char> binary = compilers->Take(source.key);
    return !binary.empty() && BuildFromBinary(source, binary.data(), binary.size());
}

bool Program::BuildFromBinary(const ProgramSource& source, const unsigned char* data,
                              std::size_t bytes) {
    const Device::Handles& handles = _device->GetHandles();
    cl_int status = CL_SUCCESS;
    cl_int code = CL_SUCCESS;
    cl_program program = clCreateProgramWithBinary(handles.context, 1, &handles.device, &bytes,
                                                   &data, &status, &code);
    if (code != CL_SUCCESS) {
        return false;
    }
    if (clBuildProgram(program, 1, &handles.device, source.options.c_str(), nullptr, nullptr) !=
        CL_SUCCESS) {
        clReleaseProgram(program);
        return false;
    }
    _program = program;
    return true;
}

void Program::BuildFromSource(const ProgramSource& source) {
    const Device::Handles& handles = _device->GetHandles();
    const char* textPointer = source.text->c_str();
    const std::size_t textBytes = source.text->size();
    cl_int code = CL_SUCCESS;
    cl_program program =
        clCreateProgramWithSource(handles.context, 1, &textPointer, &textBytes, &code);
    CheckOpenCl(code, "creating program " + _root);
    code = clBuildProgram(program, 1, &handles.device, source.options.c_str(), nullptr, nullptr);
    if (code != CL_SUCCESS) {
        const std::string log = NameKernelLines(BuildLog(program, handles.device), *source.text);
        clReleaseProgram(program);
        throw Error("building " + _root + " for " + _device->Properties().name + " with " +
                    source.options + ": " + OpenClErrorName(code) + "\n" + log);
    }
    _program = program;
}

std::vector<unsigned char> Program::Binary() const {
    std::size_t bytes = 0;
    if (clGetProgramInfo(AsProgram(_program), CL_PROGRAM_BINARY_SIZES, sizeof(bytes), &bytes,
                         nullptr) != CL_SUCCESS) {
        return {};
    }
    std::vector<unsigned char> binary(bytes);
    unsigned char* pointer = binary.data();
    if (bytes > 0 && clGetProgramInfo(AsProgram(_program), CL_PROGRAM_BINARIES, sizeof(pointer),
                                      &pointer, nullptr) != CL_SUCCESS) {
        return {};
    }
    return binary;
}

void Program::SaveBinary(Store* store) {
    const std::string key = std::exchange(_unsavedKey, {});
    // A store that keeps nothing must not ask for what the driver may have to compile.
    if (store == nullptr || !store->IsWriting() || key.empty()) {
        return;
    }
    const std::vector<unsigned char> binary = Binary();
    if (!binary.empty()) {
        store->Save(kBinaryKind, key, binary.data(), binary.size());
    }
}

void Program::SaveBinary(const ProgramSource& source, const void* binary, std::size_t bytes,
                         Store* store) {
    store->Save(kBinaryKind, source.key, binary, bytes);
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

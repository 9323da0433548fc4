// SPDX-License-Identifier: Apache-2.0
#include "hdStream/film/denoiser.h"

#include "hdStream/base/error.h"

#include <dlfcn.h>

#include <algorithm>
#include <mutex>
#include <vector>

namespace hds {

namespace {

/// Version 2 of the C API, which newer ones keep.
constexpr const char* kLibraryName = "libOpenImageDenoise.so.2";
constexpr int kDeviceTypeCpu = 1;
constexpr int kFormatFloat3 = 3;

std::mutex librariesMutex;

/// Guarded by librariesMutex.
std::vector<std::string>& Libraries() {
    static std::vector<std::string> files;
    return files;
}

std::vector<std::string> Candidates() {
    const std::lock_guard<std::mutex> lock(librariesMutex);
    std::vector<std::string> files = Libraries();
    files.emplace_back(kLibraryName);
    return files;
}

/// The handle of the first that can be loaded. It is never closed: the library keeps threads.
void* Load() {
    std::string reasons;
    for (const std::string& file : Candidates()) {
        if (void* handle = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL)) {
            return handle;
        }
        const char* reason = dlerror();
        reasons += std::string(reasons.empty() ? "" : "; ") + (reason != nullptr ? reason : file);
    }
    throw Error("--denoise: Open Image Denoise 2 was not found (" + reasons +
                "); pip install pyoidn brings it");
}

} // namespace

void AddDenoiserLibrary(const std::string& file) {
    const std::lock_guard<std::mutex> lock(librariesMutex);
    std::vector<std::string>& files = Libraries();
    if (std::find(files.begin(), files.end(), file) == files.end()) {
        files.push_back(file);
    }
}

void CheckDenoiser() {
    const Denoiser denoiser;
}

/// The functions that are used, with the types of oidn.h.
struct Denoiser::Library {
    void* handle = Load();
    void* (*newDevice)(int) = Find<void*(int)>("oidnNewDevice");
    void (*commitDevice)(void*) = Find<void(void*)>("oidnCommitDevice");
    void (*releaseDevice)(void*) = Find<void(void*)>("oidnReleaseDevice");
    int (*getError)(void*, const char**) = Find<int(void*, const char**)>("oidnGetDeviceError");
    void* (*newFilter)(void*, const char*) = Find<void*(void*, const char*)>("oidnNewFilter");
    void (*setImage)(void*, const char*, void*, int, std::size_t, std::size_t, std::size_t,
                     std::size_t, std::size_t) =
        Find<void(void*, const char*, void*, int, std::size_t, std::size_t, std::size_t,
                  std::size_t, std::size_t)>("oidnSetSharedFilterImage");
    void (*setBool)(void*, const char*,
                    bool) = Find<void(void*, const char*, bool)>("oidnSetFilterBool");
    void (*commitFilter)(void*) = Find<void(void*)>("oidnCommitFilter");
    void (*executeFilter)(void*) = Find<void(void*)>("oidnExecuteFilter");
    void (*releaseFilter)(void*) = Find<void(void*)>("oidnReleaseFilter");

    template <typename Function>
    Function* Find(const char* name) const {
        void* const function = dlsym(handle, name);
        if (function == nullptr) {
            throw Error(std::string("--denoise: Open Image Denoise has no function ") + name);
        }
        return reinterpret_cast<Function*>(function);
    }

    /// \throws Error when the library has noted one.
    void Check(void* device) const {
        const char* message = nullptr;
        if (getError(device, &message) != 0) {
            throw Error(std::string("--denoise: Open Image Denoise: ") +
                        (message != nullptr ? message : "no reason given"));
        }
    }
};

Denoiser::Denoiser() : _library(std::make_unique<Library>()) {
    _device = _library->newDevice(kDeviceTypeCpu);
    _library->Check(_device);
    _library->commitDevice(_device);
    _library->Check(_device);
}

Denoiser::~Denoiser() {
    _library->releaseDevice(_device);
}

void Denoiser::Apply(const ImageLayer* albedo, const ImageLayer* normal, ImageLayer* color) const {
    void* const filter = _library->newFilter(_device, "RT");
    const auto set = [&](const char* name, const ImageLayer* layer) {
        // Written to only as the output, which is the colour's.
        auto* const values = const_cast<float*>(layer->values.data());
        const std::size_t pixelBytes = layer->channels.size() * sizeof(float);
        _library->setImage(filter, name, values, kFormatFloat3, layer->width, layer->height, 0,
                           pixelBytes, pixelBytes * layer->width);
    };
    set("color", color);
    set("output", color);
    if (albedo != nullptr) {
        set("albedo", albedo);
        if (normal != nullptr) { // the library takes no normals without albedo
            set("normal", normal);
        }
    }
    _library->setBool(filter, "hdr", true);
    _library->commitFilter(filter);
    _library->executeFilter(filter);
    _library->releaseFilter(filter);
    _library->Check(_device);
}

} // namespace hds

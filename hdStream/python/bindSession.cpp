// SPDX-License-Identifier: Apache-2.0
// Session for Python. Every call that may take long or a lock of the core releases the GIL, and the
// callbacks take it, so that the core never waits for Python while Python waits for the core.
#include "hdStream/python/bindings.h"
#include "hdStream/python/bufferSpan.h"
#include "hdStream/session/memorySize.h"
#include "hdStream/session/session.h"
#include "hdStream/session/settingsTable.h"
#include "hdStream/session/warningDigest.h"

#include <nanobind/stl/array.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/set.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/variant.h>
#include <nanobind/stl/vector.h>

#include <memory>
#include <optional>

namespace nb = nanobind;
using namespace nb::literals;

namespace hds::python {

namespace {

using ReleaseGil = nb::call_guard<nb::gil_scoped_release>;

/// Waits without the GIL: the threads may be about to warn. All else goes with it.
class PythonSession final : public Session {
public:
    using Session::Session;
    ~PythonSession() {
        const nb::gil_scoped_release released;
        EndThreads();
    }
};

Session::WarningSink WarningSinkFromPython(nb::object onWarning) {
    if (onWarning.is_none()) {
        return {};
    }
    return [held = ShareObject(std::move(onWarning))](const std::string& line) {
        const nb::gil_scoped_acquire gil;
        try {
            (*held)(line);
        } catch (nb::python_error& error) {
            if (error.matches(PyExc_KeyboardInterrupt)) {
                PyErr_SetInterrupt(); // Ctrl-C is not the callback's: raise it where Python goes on
            } else {
                error.discard_as_unraisable("hdstream: the warning callback");
            }
        }
    };
}

/// Callbacks (Progress) -> bool and () -> bool of Python that the core asks without the GIL.
/// Pending signals are looked at with both; an exception of any stops what goes on, and is raised
/// after it.
class Callbacks {
public:
    Callbacks(nb::object onProgress, nb::object isCancelled)
        : _onProgress(std::move(onProgress)), _isCancelled(std::move(isCancelled)) {}

    ProgressCallback OnProgress() {
        return [this](const Progress& progress) {
            return MayGoOn(
                [&] { return _onProgress.is_none() || nb::cast<bool>(_onProgress(progress)); });
        };
    }

    RenderWatch Watch() {
        RenderWatch watch;
        watch.isCancelled = [this] {
            return !MayGoOn(
                [&] { return _isCancelled.is_none() || !nb::cast<bool>(_isCancelled()); });
        };
        return watch;
    }

    void Raise() {
        if (_raised) {
            throw nb::python_error(std::move(*_raised));
        }
    }

private:
    template <typename Callback>
    bool MayGoOn(const Callback& callback) {
        const nb::gil_scoped_acquire gil;
        try {
            if (PyErr_CheckSignals() != 0) {
                throw nb::python_error();
            }
            return callback();
        } catch (nb::python_error& error) {
            _raised.emplace(std::move(error));
            return false;
        }
    }

    nb::object _onProgress;
    nb::object _isCancelled;
    std::optional<nb::python_error> _raised;
};

/// Renders without the GIL. `onProgress` is asked after every wave, `isCancelled` inside of waves.
RenderResult Render(Session& session, const Settings& settings, nb::object onProgress,
                    const std::vector<FilmSums>& start, nb::object isCancelled) {
    Callbacks callbacks(std::move(onProgress), std::move(isCancelled));
    RenderResult result = RenderResult::Stopped;
    {
        const nb::gil_scoped_release released;
        result = session.Render(settings, callbacks.OnProgress(), start, callbacks.Watch());
    }
    callbacks.Raise();
    return result;
}

/// Session::Prepare without the GIL. \return nothing when it was cancelled.
std::optional<PreparedAmount> Prepare(Session& session, const Settings& settings,
                                      nb::object onProgress) {
    Callbacks callbacks(std::move(onProgress), nb::none());
    PreparedAmount amount;
    RenderResult result = RenderResult::Stopped;
    {
        const nb::gil_scoped_release released;
        result = session.Prepare(settings, callbacks.OnProgress(), &amount);
    }
    callbacks.Raise();
    return result == RenderResult::Complete ? std::make_optional(amount) : std::nullopt;
}

void BindErrors(nb::module_& module) {
    static nb::handle failure = nb::exception<Error>(module, "Error", PyExc_RuntimeError).release();
    static nb::handle usage =
        PyErr_NewException("hdstream._core.UsageError", failure.ptr(), nullptr);
    module.attr("UsageError") = usage;
    nb::register_exception_translator([](const std::exception_ptr& pointer, void*) {
        try {
            std::rethrow_exception(pointer);
        } catch (const Error& error) {
            const nb::handle type = error.kind() == ErrorKind::Usage ? usage : failure;
            PyErr_SetString(type.ptr(), error.what());
        }
    });
}

void BindSettings(nb::module_& module) {
    nb::class_<Settings> settings(module, "Settings", "All settings of a render.");
    settings.def(nb::init<>());
#define HDS_SETTING(type, name, ...) settings.def_rw(#name, &Settings::name);
#define HDS_SETTING_WITHOUT_ROW(type, name, initial) settings.def_rw(#name, &Settings::name);
#include "hdStream/session/settings.def"
}

void BindSettingsTable(nb::module_& module) {
    nb::enum_<SettingKind>(module, "SettingKind")
        .value("Bool", SettingKind::Bool)
        .value("Integer", SettingKind::Integer)
        .value("Number", SettingKind::Number)
        .value("Bytes", SettingKind::Bytes)
        .value("Text", SettingKind::Text)
        .value("Memory", SettingKind::Memory)
        .value("Choice", SettingKind::Choice)
        .value("Names", SettingKind::Names);
    nb::enum_<SettingGroup>(module, "SettingGroup")
        .value("Framing", SettingGroup::Framing)
        .value("Quality", SettingGroup::Quality)
        .value("Picture", SettingGroup::Picture)
        .value("Memory", SettingGroup::Memory)
        .value("Machine", SettingGroup::Machine);
    nb::class_<SettingInfo>(module, "SettingInfo", "A row of the settings table.")
        .def_ro("name", &SettingInfo::name)
        .def_ro("option", &SettingInfo::option)
        .def_ro("label", &SettingInfo::label)
        .def_ro("description", &SettingInfo::description)
        .def_ro("kind", &SettingInfo::kind)
        .def_ro("choices", &SettingInfo::choices)
        .def_ro("formerChoices", &SettingInfo::formerChoices)
        .def_ro("minimum", &SettingInfo::minimum)
        .def_ro("maximum", &SettingInfo::maximum)
        .def_ro("group", &SettingInfo::group)
        .def_prop_ro("isUserSetting", &SettingInfo::IsUserSetting)
        .def_prop_ro("isAdvanced", &SettingInfo::IsAdvanced);
    module.def("SettingTable", &SettingTable, "All settings, in the order they are shown.");
    module.def("GetSetting", &GetSetting, "settings"_a, "name"_a);
    module.def("SetSetting", &SetSetting, "settings"_a, "name"_a, "value"_a,
               "Sets a checked value; raises UsageError. A note where its spelling is a former "
               "one; else ''.");
    module.def("ParseBytes", &ParseBytes, "text"_a, "Of a size such as 512M; raises UsageError.");
    module.def(
        "ParseMemorySize",
        [](const std::string& text) {
            const MemorySize size = ParseMemorySize(text);
            return std::pair(size.bytes, size.share);
        },
        "text"_a, "(bytes, share) of a size such as 512M or 30%; raises UsageError.");
}

void BindDevices(nb::module_& module) {
    nb::class_<DeviceInfo>(module, "DeviceInfo", "An OpenCL device.")
        .def_ro("name", &DeviceInfo::name)
        .def_ro("platform", &DeviceInfo::platform)
        .def_ro("version", &DeviceInfo::version)
        .def_ro("driverVersion", &DeviceInfo::driverVersion)
        .def_ro("memoryBytes", &DeviceInfo::memoryBytes)
        .def_ro("maxAllocationBytes", &DeviceInfo::maxAllocationBytes)
        .def_ro("computeUnits", &DeviceInfo::computeUnits)
        .def_ro("isCpu", &DeviceInfo::isCpu);
    module.def("ListDevices", &ListDevices, ReleaseGil(), "All OpenCL devices of the machine.");
    module.def("FindDevice", &FindDevice, ReleaseGil(), "name"_a,
               "The device that renders when it is asked for by that part of its name.");

    nb::class_<CachedStage>(module, "CachedStage", "Pages of the cache that belong to a stage.")
        .def_ro("file", &CachedStage::file)
        .def_ro("pages", &CachedStage::pages)
        .def_ro("bytes", &CachedStage::bytes);
    nb::class_<CacheState>(module, "CacheState", "The persistent cache.")
        .def_ro("directory", &CacheState::directory)
        .def_ro("bytes", &CacheState::bytes)
        .def_ro("stages", &CacheState::stages)
        .def_ro("otherPages", &CacheState::otherPages)
        .def_ro("otherBytes", &CacheState::otherBytes);
    nb::class_<PreparedAmount>(module, "PreparedAmount", "What Session.Prepare has left there.")
        .def_ro("chunks", &PreparedAmount::chunks)
        .def_ro("chunksBuilt", &PreparedAmount::chunksBuilt)
        .def_ro("chunkBytes", &PreparedAmount::chunkBytes)
        .def_ro("textures", &PreparedAmount::textures)
        .def_ro("texturesBuilt", &PreparedAmount::texturesBuilt);
    module.def("KernelSourceHash", &KernelSourceHash,
               "Of all kernel sources: equal bits need equal kernels.");
    module.def("InspectCache", &InspectCache, ReleaseGil(), "directory"_a);
    module.def("ClearCache", &ClearCache, ReleaseGil(), "directory"_a,
               "Deletes all entries; returns their bytes.");

    module.def("PrepareKernels", &PrepareKernels, ReleaseGil(), "device"_a, "directory"_a,
               "Compiles the general kernels of a device into the cache; returns warnings.");

    nb::enum_<RenderResult>(module, "RenderResult")
        .value("Complete", RenderResult::Complete)
        .value("Stopped", RenderResult::Stopped);
    nb::class_<WorkCount>(module, "WorkCount", "How much of some work is done.")
        .def_ro("done", &WorkCount::done)
        .def_ro("total", &WorkCount::total);
    nb::class_<Progress>(module, "Progress", "How far a render is.")
        .def_ro("samplesDone", &Progress::samplesDone)
        .def_ro("samplesTotal", &Progress::samplesTotal)
        .def_ro("fraction", &Progress::fraction)
        .def_ro("secondsElapsed", &Progress::secondsElapsed)
        .def_ro("secondsLeft", &Progress::secondsLeft)
        .def_ro("previewStride", &Progress::previewStride)
        .def_ro("prims", &Progress::prims)
        .def_ro("chunks", &Progress::chunks)
        .def_ro("textures", &Progress::textures);
}

} // namespace

void BindSession(nb::module_& module) {
    BindErrors(module);
    BindSettings(module);
    BindSettingsTable(module);
    BindDevices(module);
    module.def("DigestWarnings", &DigestWarnings, "lines"_a, "One line a kind, with three names.");
    nb::class_<Session>(module, "SessionCalls", "What a Session does.")
        .def("SetGeometry", &Session::SetGeometry, "path"_a, "prim"_a)
        .def("SetCategories", &Session::SetCategories, "path"_a, "categories"_a,
             "What geometry or a volume that is there is linked to.")
        .def("SetVolume", &Session::SetVolume, "path"_a, "prim"_a)
        .def("SetInstancer", &Session::SetInstancer, "path"_a, "prim"_a)
        .def("SetLight", &Session::SetLight, "path"_a, "prim"_a)
        .def(
            "SetMaterial",
            [](Session& self, const std::string& path, MaterialNetwork network) {
                self.SetMaterial(path, std::make_shared<const MaterialNetwork>(std::move(network)));
            },
            "path"_a, "network"_a)
        .def("SetCamera", &Session::SetCamera, "path"_a, "prim"_a)
        .def("Remove", &Session::Remove, "path"_a)
        .def("Clear", &Session::Clear, ReleaseGil())
        .def("Scene", &Session::Scene, nb::rv_policy::reference_internal)
        .def("Warn", &Session::Warn, ReleaseGil(), "subject"_a, "text"_a)
        .def("Warnings", &Session::Warnings, ReleaseGil())
        .def("Dump", &Session::Dump, ReleaseGil())
        .def("Info", &Session::Info, ReleaseGil())
        .def("Warm", &Session::Warm, ReleaseGil(), "settings"_a)
        .def("SetStageFile", &Session::SetStageFile, "file"_a)
        .def("Prepare", &Prepare, "settings"_a, "onProgress"_a = nb::none(),
             "What was prepared; None when it was cancelled.")
        .def("Render", &Render, "settings"_a, "onProgress"_a = nb::none(),
             "start"_a = std::vector<FilmSums>(), "isCancelled"_a = nb::none())
        .def("Film", &Session::Film, ReleaseGil())
        .def("Redice", &Session::Redice)
        .def("HasImage", &Session::HasImage)
        .def("Layers", &Session::Layers, ReleaseGil(), "withFirstHits"_a = true)
        .def("Deep", &Session::Deep, ReleaseGil())
        .def("FlushTextures", &Session::FlushTextures, ReleaseGil())
        .def("Statistics", &Session::Statistics, ReleaseGil())
        .def("SetFrontEndTimes", &Session::SetFrontEndTimes, "loadSeconds"_a, "translateSeconds"_a,
             "sinceStartSeconds"_a);
    nb::class_<PythonSession, Session>(module, "Session", "A scene, its device and its film.")
        .def(
            "__init__",
            [](PythonSession* self, nb::object onWarning) {
                new (self) PythonSession(WarningSinkFromPython(std::move(onWarning)));
            },
            "onWarning"_a = nb::none());
}

} // namespace hds::python

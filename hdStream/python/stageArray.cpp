// SPDX-License-Identifier: Apache-2.0
#include "hdStream/python/stageArray.h"

#include "hdStream/python/bufferSpan.h"
#include "hdStream/session/frontEndArrays.h"

#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <utility>

namespace nb = nanobind;
using namespace nb::literals;

namespace hds::python {

namespace {

ArrayBytes BytesOf(nb::handle array, char format, const char* what, std::size_t* itemsPerRow) {
    constexpr std::size_t kItemBytes = 4; // of float32 and int32
    auto buffer = std::make_unique<HeldBuffer>(array, format, kItemBytes, what);
    ArrayBytes bytes;
    bytes.data = buffer->data();
    bytes.bytes = buffer->numItems() * kItemBytes;
    *itemsPerRow = buffer->itemsPerRow();
    bytes.owner = ShareBuffer(std::move(buffer));
    return bytes;
}

/// Calls `read`; what Python raises becomes an Error. An interruption by the user waits until the
/// array is there: the render asks for it between its waves.
ArrayBytes Read(const nb::object& read, char format) {
    const nb::gil_scoped_acquire gil;
    for (bool isInterrupted = false;; isInterrupted = true) {
        try {
            const nb::object array = read();
            std::size_t itemsPerRow = 1;
            ArrayBytes bytes = BytesOf(array, format, "array", &itemsPerRow);
            if (isInterrupted) {
                PyErr_SetInterrupt();
            }
            return bytes;
        } catch (nb::python_error& error) {
            if (!error.matches(PyExc_KeyboardInterrupt) || isInterrupted) {
                const nb::object text = nb::str(error.value());
                throw Error(nb::cast<std::string>(text));
            }
        } catch (const std::exception& error) { // no array of this type
            throw Error(error.what());
        }
    }
}

/// A source whose files are watched as long as it lives.
std::shared_ptr<const ArraySource> WatchFiles(std::unique_ptr<const ArraySource> source,
                                              const std::vector<std::string>& paths) {
    if (paths.empty()) {
        return source;
    }
    ArrayFiles::Watch(source.get(), paths);
    return {source.release(), [](const ArraySource* watched) {
                ArrayFiles::Forget(watched);
                delete watched;
            }};
}

} // namespace

StageArray::StageArray(const std::string& name, nb::handle values, nb::object read) {
    ArrayBytes first;
    try {
        first = BytesOf(values, _format, name.c_str(), &_itemsPerRow);
    } catch (const nb::builtin_exception&) { // not of floats
        _format = 'i';
        first = BytesOf(values, _format, name.c_str(), &_itemsPerRow);
    }
    std::vector<std::string> files;
    if (nb::hasattr(read, "files")) {
        files = nb::cast<std::vector<std::string>>(read.attr("files"));
    }
    _source = WatchFiles(
        std::make_unique<const ArraySource>(name, std::move(first),
                                            [held = ShareObject(std::move(read)),
                                             format = _format] { return Read(*held, format); }),
        files);
}

void BindStageArray(nb::module_& module) {
    nb::class_<StageArray>(module, "StageArray", "An array that is read again when it is needed.")
        .def(nb::init<const std::string&, nb::handle, nb::object>(), "name"_a, "values"_a, "read"_a,
             "`values`: a float32 or int32 array as it is now. `read`: a function without "
             "parameters that gives the same array at any later time; its attribute `files`, where "
             "it has one, are the paths of files that arrays may be mapped from. `name` starts the "
             "line of an error.");
    module.def(
        "ArrayCounts",
        [] {
            const ArrayCounts counts = ArraySource::Counts();
            nb::dict result;
            result["bytes"] = counts.bytes;
            result["keptBytes"] = counts.keptBytes;
            result["readBytes"] = counts.readBytes;
            result["poolBytes"] = arrayBlockBytes.load();
            return result;
        },
        "Of all StageArrays: bytes; those that wait in memory; those that were read again. And the "
        "bytes of the blocks that hold small arrays.");
}

} // namespace hds::python

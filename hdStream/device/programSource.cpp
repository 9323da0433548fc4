// SPDX-License-Identifier: Apache-2.0
#include "hdStream/device/programSource.h"

#include "hdStream/base/hash.h"
#include "hdStream/device/kernelSource.h"

#include "kernels/shared/lightPaths.h"
#include "kernels/shared/material.h"
#include "kernels/shared/residency.h"

#include <algorithm>
#include <set>
#include <string_view>

namespace hds {

namespace {

/// Raised when the way programs are built changes.
constexpr std::uint64_t kKernelAbi = 1;

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

/// All names that begin as those of the table do.
std::set<std::string_view> NamesIn(std::string_view text) {
    constexpr std::string_view kPrefix = "HDS_";
    constexpr std::string_view kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_abcdefghijklmnopqrs"
                                          "tuvwxyz";
    std::set<std::string_view> names;
    for (std::size_t at = text.find(kPrefix); at != std::string_view::npos;) {
        const std::size_t end = std::min(text.find_first_not_of(kLetters, at), text.size());
        names.insert(text.substr(at, end - at));
        at = text.find(kPrefix, end);
    }
    return names;
}

/// Only what the text names: scenes that differ in other features share the binary.
std::string OptionsOf(const ProgramDefines& said, std::string_view text) {
    const std::set<std::string_view> names = NamesIn(text);
    std::string options = "-cl-std=CL1.2";
    for (const auto& [name, value] : Complete(said)) {
        if (names.count(name) > 0) {
            options.append(" -D").append(name).append("=").append(value);
        }
    }
    return options;
}

std::string BinaryKey(const DeviceProperties& device, const std::string& text,
                      const std::string& options) {
    Hasher hasher;
    hasher.Append(kKernelAbi);
    for (const std::string* part : {&text, &options, &device.platform, &device.name,
                                    &device.version, &device.driverVersion}) {
        hasher.Append(std::string_view(*part));
    }
    return hasher.Hex();
}

} // namespace

ProgramSource MakeProgramSource(const DeviceProperties& device, const std::string& root,
                                const ProgramDefines& defines, const std::string* text) {
    ProgramSource source;
    source.root = root;
    source.text = ExpandKernelSource(root, text);
    source.options = OptionsOf(defines, source.text);
    source.key = BinaryKey(device, source.text, source.options);
    return source;
}

} // namespace hds

// SPDX-License-Identifier: Apache-2.0
#include "hdStream/device/programSource.h"

#include "hdStream/base/hash.h"
#include "hdStream/device/kernelSource.h"

#include "kernels/shared/lightPaths.h"
#include "kernels/shared/material.h"
#include "kernels/shared/residency.h"

#include <algorithm>
#include <map>
#include <mutex>
#include <set>
#include <string_view>

namespace hds {

namespace {

/// Raised when the way programs are built changes.
constexpr std::uint64_t kKernelAbi = 2;

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

/// The text of a program, and what options and key are made of.
struct ProgramText {
    std::string text;
    std::string hash;
    std::set<std::string_view> macros; ///< in the text: all names that begin as those of the table
};

std::set<std::string_view> MacrosIn(std::string_view text) {
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

std::shared_ptr<const ProgramText> MakeText(const std::string& root, const std::string* text) {
    auto made = std::make_shared<ProgramText>();
    made->text = ExpandKernelSource(root, text);
    Hasher hasher;
    hasher.Append(std::string_view(made->text));
    made->hash = hasher.Hex();
    made->macros = MacrosIn(made->text);
    return made;
}

/// Of a root of kernels/. Renders ask for the same few again and again (which kernels are in the
/// store?), so the texts of roots that cannot change are kept. Any thread.
std::shared_ptr<const ProgramText> TextOf(const std::string& root) {
    if (!AreKernelsEmbedded()) {
        return MakeText(root, nullptr);
    }
    static std::mutex mutex;
    static std::map<std::string, std::shared_ptr<const ProgramText>> texts;
    const std::lock_guard<std::mutex> lock(mutex);
    std::shared_ptr<const ProgramText>& text = texts[root];
    if (text == nullptr) {
        text = MakeText(root, nullptr);
    }
    return text;
}

/// Only what the text names: scenes that differ in other features share the binary.
std::string OptionsOf(const DeviceProperties& device, const ProgramDefines& said,
                      const std::set<std::string_view>& macros) {
    std::string options = "-cl-std=CL1.2";
    if (device.roundsWhenAsked) {
        options += " -cl-fp32-correctly-rounded-divide-sqrt";
    }
    for (const auto& [name, value] : Complete(said)) {
        if (macros.count(name) > 0) {
            options.append(" -D").append(name).append("=").append(value);
        }
    }
    return options;
}

std::string BinaryKey(const DeviceProperties& device, const std::string& textHash,
                      const std::string& options) {
    Hasher hasher;
    hasher.Append(kKernelAbi);
    for (const std::string* part : {&textHash, &options, &device.platform, &device.name,
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
    const auto made = text != nullptr ? MakeText(root, text) : TextOf(root);
    source.text = {made, &made->text};
    source.options = OptionsOf(device, defines, made->macros);
    source.key = BinaryKey(device, made->hash, source.options);
    return source;
}

} // namespace hds

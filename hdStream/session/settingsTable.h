// SPDX-License-Identifier: Apache-2.0
// The one table of all settings: the command line, the "hdstream:" attributes of render settings
// prims, Hydra's render setting descriptors and docs/settings.md come from it.
#pragma once

#include "hdStream/session/settings.h"

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

namespace hds {

/// A setting's value, in the type of its kind.
using SettingValue =
    std::variant<bool, std::int64_t, double, std::string, std::vector<std::string>>;

/// What a setting's value may be.
enum class SettingKind {
    Bool,
    Integer, ///< whole number in [minimum, maximum]
    Number,  ///< finite number in [minimum, maximum]
    Bytes,   ///< whole number of bytes; the command line takes suffixes K, M, G
    Text,
    Choice, ///< one of `choices`
    Names,  ///< a list of words
};

/// One row.
struct SettingInfo {
    std::string name;   ///< member of Settings; "hdstream:NAME" in USD, NAME in Hydra
    std::string option; ///< of the command line with its dashes; empty: it has none
    std::string label;  ///< a few words for user interfaces
    std::string description;
    SettingKind kind = SettingKind::Bool;
    std::vector<std::string> choices;
    double minimum = 0.0;
    double maximum = 0.0;
    /// False: hosts of the renderer decide it (image size, camera, purposes ...), so Hydra offers
    /// no descriptor.
    bool isUserSetting = true;
};

/// All rows, in the order they are shown to users. Thread-safe. Every setting has one but
/// displayWindow and dataWindowMin, which follow from what the front end is asked to frame.
const std::vector<SettingInfo>& SettingTable();

/// The row of that name; null when there is none.
const SettingInfo* FindSetting(const std::string& name);

/// The present value. Precondition: the table has the name.
SettingValue GetSetting(const Settings& settings, const std::string& name);

/// \throws Error (usage) that names the option, unless the value, which has the type of the
/// setting's kind, is in range.
void CheckSettingValue(const SettingInfo& info, const SettingValue& value);

/// Sets a value; numbers convert to the setting's kind when they keep their value.
/// \throws Error (usage) that names the option, for an unknown name, a wrong type or a value out of
/// range.
void SetSetting(Settings* settings, const std::string& name, const SettingValue& value);

} // namespace hds

// SPDX-License-Identifier: Apache-2.0
// The table of all settings (settings.def) at run time: for the command line, the "hdstream:"
// attributes of render settings prims, Hydra's descriptors and docs/settings.md.
#pragma once

#include "hdStream/session/settings.h"

#include <cstdint>
#include <map>
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
    Memory, ///< text: a size or a percentage (memorySize.h); empty: the default
    Choice, ///< one of `choices`
    Names,  ///< a list of words
};

/// Where command lines show it. Those of Memory and Machine change no bit of a picture.
enum class SettingGroup { Framing, Quality, Picture, Memory, Machine };

/// Whose choice it is.
enum class SettingAudience {
    Host, ///< hosts of the renderer decide it (image size, camera ...): Hydra offers no descriptor
    User, ///< offered to everybody
    Expert, ///< offered last, and as advanced: nobody needs it for a picture
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
    SettingGroup group = SettingGroup::Framing;
    SettingAudience audience = SettingAudience::Host;
    /// Of choices as the version before spelled them: the present spelling.
    std::map<std::string, std::string> formerChoices;

    bool IsUserSetting() const { return audience != SettingAudience::Host; }
    bool IsAdvanced() const { return audience == SettingAudience::Expert; }
};

/// All rows, in the order they are shown to users. Thread-safe.
const std::vector<SettingInfo>& SettingTable();

/// The row of that name; null when there is none.
const SettingInfo* FindSetting(const std::string& name);

/// The present value. Precondition: the table has the name.
SettingValue GetSetting(const Settings& settings, const std::string& name);

/// \throws Error (usage) that names the option, unless the value, which has the type of the
/// setting's kind, is in range.
void CheckSettingValue(const SettingInfo& info, const SettingValue& value);

/// Sets a value; numbers convert to the setting's kind when they keep their value.
/// \return a note for the user where a choice is spelled as in the version before; else empty.
/// \throws Error (usage) that names the option, for an unknown name, a wrong type or a value out of
/// range.
std::string SetSetting(Settings* settings, const std::string& name, const SettingValue& value);

} // namespace hds

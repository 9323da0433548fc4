// SPDX-License-Identifier: Apache-2.0
#include "hdStream/session/settingsTable.h"

#include "hdStream/base/error.h"
#include "hdStream/session/memorySize.h"
#include "hdStream/session/settingsCheck.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <type_traits>
#include <utility>

namespace hds {

namespace {

struct Row {
    SettingInfo info;
    std::function<SettingValue(const Settings&)> get;
    std::function<void(Settings*, const SettingValue&)> set; ///< the value is checked
};

constexpr double kMaxSeconds = 1e9;
constexpr double kMaxError = 1e6;
constexpr double kMaxFilterWidth = 64.0;
constexpr double kMaxMipBias = 16.0;
constexpr double kMaxStops = 32.0;
constexpr double kMaxShadeIterations = 64.0;
constexpr double kMaxPixelAspect = 1000.0;
/// Path depths are kept in 16 bits together with their sampling dimensions.
constexpr double kMaxDepth = 4096;
constexpr double kMaxDeepSamples = 4096;
constexpr double kMaxClamp = 1e6;
constexpr double kMaxDistance = 1e30; ///< scene units
constexpr double kMaxCount = 1U << 24U;
constexpr double kMaxSeed = std::numeric_limits<std::uint32_t>::max();
constexpr double kMaxRefineLevel = 8;
constexpr double kMinChunkBytes = 4U << 10U;
constexpr double kMaxChunkBytes = 256U << 20U;
constexpr double kMaxHostBytes = 1ULL << 50U;

/// What a setting may be: the table's column of values.
struct Values {
    SettingKind kind = SettingKind::Bool;
    std::vector<std::string> choices;
    double minimum = 0.0;
    double maximum = 0.0;
};

Values Flag() {
    return {SettingKind::Bool, {}};
}
Values Whole(double minimum, double maximum) {
    return {SettingKind::Integer, {}, minimum, maximum};
}
Values Number(double minimum, double maximum) {
    return {SettingKind::Number, {}, minimum, maximum};
}
Values Bytes(double minimum, double maximum) {
    return {SettingKind::Bytes, {}, minimum, maximum};
}
Values Text() {
    return {SettingKind::Text, {}};
}
Values Memory() {
    return {SettingKind::Memory, {}};
}
Values Names() {
    return {SettingKind::Names, {}};
}
template <typename... Choices>
Values OneOf(Choices... choices) {
    return {SettingKind::Choice, {choices...}};
}

std::map<std::string, std::string> FormerChoicesOf(const std::string& setting) {
    std::map<std::string, std::string> choices;
#define HDS_FORMER_CHOICE(name, former, choice) \
    if (setting == #name) {                     \
        choices.emplace(former, choice);        \
    }
#include "hdStream/session/settings.def"
    return choices;
}

template <typename T>
Row MakeRow(T Settings::*member, const char* name, Values values, const char* option,
            SettingGroup group, SettingAudience audience, const char* label,
            const char* description) {
    // What a member of this type is in a SettingValue.
    using Held = std::conditional_t<
        std::is_same_v<T, bool>, bool,
        std::conditional_t<std::is_integral_v<T>, std::int64_t,
                           std::conditional_t<std::is_floating_point_v<T>, double, T>>>;
    return {{name, option, label, description, values.kind, std::move(values.choices),
             values.minimum, values.maximum, group, audience, FormerChoicesOf(name)},
            [member](const Settings& settings) {
                return SettingValue(static_cast<Held>(settings.*member));
            },
            [member](Settings* settings, const SettingValue& value) {
                settings->*member = static_cast<T>(std::get<Held>(value));
            }};
}

const std::vector<Row>& Rows() {
    static const std::vector<Row> rows{
#define HDS_SETTING(type, name, initial, values, option, group, audience, label, description) \
    MakeRow(&Settings::name, #name, values, option, SettingGroup::group,                      \
            SettingAudience::audience, label, description),
#include "hdStream/session/settings.def"
    };
    return rows;
}

const Row* FindRow(const std::string& name) {
    const auto found = std::find_if(Rows().begin(), Rows().end(),
                                    [&](const Row& row) { return row.info.name == name; });
    return found == Rows().end() ? nullptr : &*found;
}

std::string TextOf(double number) {
    char text[40];
    std::snprintf(text, sizeof(text), "%.12g", number);
    return text;
}

[[noreturn]] void Fail(const SettingInfo& info, const std::string& text) {
    throw Error((info.option.empty() ? info.name : info.option) + ": " + text, ErrorKind::Usage);
}

void CheckInRange(const SettingInfo& info, double number) {
    if (!(number >= info.minimum && number <= info.maximum)) {
        Fail(info,
             TextOf(number) + " is not in " + TextOf(info.minimum) + ".." + TextOf(info.maximum));
    }
}

void CheckIsChoice(const SettingInfo& info, const std::string& text) {
    if (std::find(info.choices.begin(), info.choices.end(), text) == info.choices.end()) {
        std::string message = text + " is none of ";
        for (std::size_t i = 0; i < info.choices.size(); ++i) {
            message += (i > 0 ? ", " : "") + info.choices[i];
        }
        Fail(info, message);
    }
}

void CheckIsMemory(const SettingInfo& info, const std::string& text) {
    if (text.empty()) {
        return;
    }
    try {
        ParseMemorySize(text);
    } catch (const Error& error) {
        Fail(info, error.what());
    }
}

/// A number that is whole, if it is.
const std::int64_t* WholeNumber(const SettingValue& value, std::int64_t* storage) {
    if (const auto* integer = std::get_if<std::int64_t>(&value)) {
        return integer;
    }
    const auto* number = std::get_if<double>(&value);
    if (number == nullptr || std::abs(*number) > 9e15 || std::floor(*number) != *number) {
        return nullptr;
    }
    *storage = static_cast<std::int64_t>(*number);
    return storage;
}

/// The value in the type of the row's kind.
SettingValue Converted(const SettingInfo& info, const SettingValue& value) {
    std::int64_t storage = 0;
    switch (info.kind) {
    case SettingKind::Bool:
        if (std::holds_alternative<bool>(value)) {
            return value;
        }
        Fail(info, "is either true or false");
    case SettingKind::Integer:
    case SettingKind::Bytes:
        if (const std::int64_t* number = WholeNumber(value, &storage)) {
            return *number;
        }
        Fail(info, "must be a whole number");
    case SettingKind::Number:
        if (const auto* integer = std::get_if<std::int64_t>(&value)) {
            return static_cast<double>(*integer);
        }
        if (std::holds_alternative<double>(value)) {
            return value;
        }
        Fail(info, "must be a number");
    case SettingKind::Text:
    case SettingKind::Memory:
    case SettingKind::Choice:
        if (std::holds_alternative<std::string>(value)) {
            return value;
        }
        Fail(info, "must be a text");
    case SettingKind::Names:
        if (std::holds_alternative<std::vector<std::string>>(value)) {
            return value;
        }
        Fail(info, "must be a list of names");
    }
    Fail(info, "has no kind");
}

} // namespace

const std::vector<SettingInfo>& SettingTable() {
    static const std::vector<SettingInfo> table = [] {
        std::vector<SettingInfo> infos;
        for (const Row& row : Rows()) {
            infos.push_back(row.info);
        }
        return infos;
    }();
    return table;
}

const SettingInfo* FindSetting(const std::string& name) {
    const Row* row = FindRow(name);
    return row != nullptr ? &row->info : nullptr;
}

SettingValue GetSetting(const Settings& settings, const std::string& name) {
    const Row* row = FindRow(name);
    HDS_VERIFY(row != nullptr, name);
    return row->get(settings);
}

void CheckSettingValue(const SettingInfo& info, const SettingValue& value) {
    if (const auto* integer = std::get_if<std::int64_t>(&value)) {
        CheckInRange(info, static_cast<double>(*integer));
    } else if (const auto* number = std::get_if<double>(&value)) {
        if (!std::isfinite(*number)) {
            Fail(info, "must be a finite number");
        }
        CheckInRange(info, *number);
    } else if (info.kind == SettingKind::Choice) {
        CheckIsChoice(info, std::get<std::string>(value));
    } else if (info.kind == SettingKind::Memory) {
        CheckIsMemory(info, std::get<std::string>(value));
    }
}

std::string SetSetting(Settings* settings, const std::string& name, const SettingValue& value) {
    const Row* row = FindRow(name);
    if (row == nullptr) {
        throw Error(name + ": there is no such setting", ErrorKind::Usage);
    }
    const SettingInfo& info = row->info;
    SettingValue converted = Converted(info, value);
    std::string note;
    if (const auto* text = std::get_if<std::string>(&converted)) {
        const auto former = info.formerChoices.find(*text);
        if (former != info.formerChoices.end()) {
            note = (info.option.empty() ? name : info.option) + ": " + former->first +
                   " is called " + former->second +
                   " now, and not known any more in the next version";
            converted = former->second;
        }
    }
    CheckSettingValue(info, converted);
    row->set(settings, converted);
    return note;
}

} // namespace hds

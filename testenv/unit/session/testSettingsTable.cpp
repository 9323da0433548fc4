// SPDX-License-Identifier: Apache-2.0
// The table reaches every setting, keeps values, and refuses what is out of range.
#include "hdStream/session/settingsTable.h"

#include "hdStream/base/error.h"
#include "hdStream/session/settingsCheck.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace hds {
namespace {

/// Another legal value than the present one.
SettingValue OtherValue(const SettingInfo& info, const SettingValue& present) {
    switch (info.kind) {
    case SettingKind::Bool:
        return !std::get<bool>(present);
    case SettingKind::Integer:
    case SettingKind::Bytes: {
        const auto low = static_cast<std::int64_t>(info.minimum);
        return std::get<std::int64_t>(present) == low ? low + 1 : low;
    }
    case SettingKind::Number:
        return std::get<double>(present) == info.maximum ? info.minimum : info.maximum;
    case SettingKind::Text:
        return std::get<std::string>(present) + "x";
    case SettingKind::Memory:
        return std::get<std::string>(present) == "30%" ? std::string("2G") : std::string("30%");
    case SettingKind::Choice:
        return std::get<std::string>(present) == info.choices[0] ? info.choices[1]
                                                                 : info.choices[0];
    case SettingKind::Names:
        return std::vector<std::string>{"alpha"};
    }
    return present;
}

void ExpectRefused(const std::string& name, const SettingValue& value, const std::string& subject) {
    Settings settings;
    try {
        SetSetting(&settings, name, value);
        ADD_FAILURE() << name << " was accepted";
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::Usage);
        EXPECT_EQ(std::string(error.what()).find(subject + ": "), 0U) << error.what();
    }
    EXPECT_EQ(settings, Settings());
}

TEST(SettingsTable, FormerSpellingsAreTakenWithANote) {
    std::size_t numFormer = 0;
    for (const SettingInfo& info : SettingTable()) {
        for (const auto& [former, choice] : info.formerChoices) {
            ++numFormer;
            Settings settings;
            const std::string note = SetSetting(&settings, info.name, former);
            EXPECT_NE(note.find(former + " is called " + choice), std::string::npos) << note;
            EXPECT_EQ(std::get<std::string>(GetSetting(settings, info.name)), choice);
            EXPECT_EQ(SetSetting(&settings, info.name, choice), "");
            EXPECT_EQ(std::count(info.choices.begin(), info.choices.end(), choice), 1);
            EXPECT_EQ(std::count(info.choices.begin(), info.choices.end(), former), 0);
        }
    }
    EXPECT_EQ(numFormer, 4U);
}

TEST(SettingsTable, EverySettingChangesOneMemberAndReadsBack) {
    std::set<std::string> names;
    for (const SettingInfo& info : SettingTable()) {
        EXPECT_TRUE(names.insert(info.name).second) << info.name;
        EXPECT_FALSE(info.label.empty() || info.description.empty()) << info.name;
        Settings settings;
        const SettingValue other = OtherValue(info, GetSetting(settings, info.name));
        SetSetting(&settings, info.name, other);
        EXPECT_NE(settings, Settings()) << info.name;
        EXPECT_EQ(GetSetting(settings, info.name), other) << info.name;
        for (const SettingInfo& unchanged : SettingTable()) {
            if (unchanged.name != info.name) {
                EXPECT_EQ(GetSetting(settings, unchanged.name),
                          GetSetting(Settings(), unchanged.name));
            }
        }
    }
}

TEST(SettingsTable, ShowsWhatExpertsTryLast) {
    // Hosts show settings in this order and have no other way to keep experts' knobs apart.
    SettingAudience last = SettingAudience::Host;
    for (const SettingInfo& info : SettingTable()) {
        EXPECT_GE(static_cast<int>(info.audience), static_cast<int>(last)) << info.name;
        last = info.audience;
    }
    EXPECT_TRUE(FindSetting("waveSize")->IsAdvanced());
    EXPECT_FALSE(FindSetting("geometryMemory")->IsAdvanced());
    EXPECT_FALSE(FindSetting("camera")->IsUserSetting());
}

TEST(SettingsTable, SettingsThatDifferWhereNoRowIsAreNotEqual) {
    Settings settings;
    settings.displayWindow = {0.0, 0.0, 2.0, 1.0};
    EXPECT_NE(settings, Settings());
    settings = Settings();
    settings.dataWindowMin = {0, 1};
    EXPECT_NE(settings, Settings());
}

TEST(SettingsTable, DefaultsAreLegal) {
    for (const SettingInfo& info : SettingTable()) {
        EXPECT_NO_THROW(CheckSettingValue(info, GetSetting(Settings(), info.name))) << info.name;
    }
    EXPECT_NO_THROW(CheckSettings(Settings()));
}

TEST(SettingsTable, RefusesWhatIsOutOfRangeOrOfAnotherType) {
    ExpectRefused("samples", std::int64_t{0}, "--samples");
    ExpectRefused("samples", std::string("many"), "--samples");
    ExpectRefused("samples", 1.5, "--samples");
    ExpectRefused("noise", std::nan(""), "--noise");
    ExpectRefused("timeLimit", -1.0, "--time");
    ExpectRefused("subdivision", std::string("some"), "--subdivision");
    ExpectRefused("domeVisible", std::int64_t{1}, "domeVisible");
    ExpectRefused("aovs", std::string("color"), "--aovs");
    ExpectRefused("geometryMemory", std::string("12Q"), "--geometryMemory");
    ExpectRefused("textureMemory", std::string("130%"), "--textureMemory");
    ExpectRefused("noSuchSetting", true, "noSuchSetting");
}

TEST(SettingsTable, NumbersConvertWhenTheyKeepTheirValue) {
    Settings settings;
    SetSetting(&settings, "samples", 16.0);
    EXPECT_EQ(settings.samples, 16U);
    SetSetting(&settings, "noise", std::int64_t{1});
    EXPECT_EQ(settings.noise, 1.0);
}

} // namespace
} // namespace hds

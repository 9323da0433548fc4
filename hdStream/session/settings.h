// SPDX-License-Identifier: Apache-2.0
// The settings of a render. What each means, and all that is made of them: settings.def.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace hds {

/// All settings: a member for each row of settings.def, with its default.
struct Settings {
    using Words = std::vector<std::string>;
    using PixelWindow = std::array<double, 4>; ///< left, top, right, bottom, y down
    using PixelPosition = std::array<std::int32_t, 2>;

#define HDS_SETTING(type, name, initial, ...) type name = initial;
#define HDS_SETTING_WITHOUT_ROW(type, name, initial) type name = initial;
#include "hdStream/session/settings.def"

    bool operator==(const Settings& other) const;
    bool operator!=(const Settings& other) const {
        return !(*this == other);
    }
};

} // namespace hds

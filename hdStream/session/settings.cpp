// SPDX-License-Identifier: Apache-2.0
#include "hdStream/session/settings.h"

namespace hds {

bool Settings::operator==(const Settings& other) const {
    bool isEqual = true;
#define HDS_SETTING(type, name, ...) isEqual = isEqual && name == other.name;
#define HDS_SETTING_WITHOUT_ROW(type, name, initial) isEqual = isEqual && name == other.name;
#include "hdStream/session/settings.def"
    return isEqual;
}

} // namespace hds

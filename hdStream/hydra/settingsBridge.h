// SPDX-License-Identifier: Apache-2.0
// Render settings between Hydra (tokens and VtValues) and the core's table of settings. Explained
// in docs/hydra.md, "Settings".
#pragma once

#include "hdStream/session/settingsTable.h"

#include <pxr/base/vt/dictionary.h>
#include <pxr/imaging/hd/renderDelegate.h>
#include <pxr/pxr.h>

#include <map>
#include <set>
#include <string>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

/// The settings that an application has made. Externally synchronised.
class HdStreamSettingsBridge {
public:
    /// One descriptor a user setting, in the table's order, with the core's default.
    static HdRenderSettingDescriptorList Descriptors();

    /// The name in the table that a key of Hydra sets: its own, one with "hdstream:" before it, or
    /// one of Hydra's common keys. Empty: the key is not ours.
    static std::string NameOf(const TfToken& key);

    /// Takes an application's value over. A wrong one changes nothing.
    /// \param problem what is wrong, when it returns false
    bool Set(const TfToken& key, const VtValue& value, std::string* problem);

    /// The value in effect, as Hydra's interfaces show it. Precondition: the table has the name.
    VtValue Get(const std::string& name) const;

    /// Defaults, then the values of the scene's render settings prim, then the application's.
    /// \param problems one line for each value of the scene that cannot be used
    hds::Settings Compose(const VtDictionary& sceneSettings, std::vector<std::string>* problems);

    /// True when the application has set it.
    bool IsSet(const std::string& name) const { return _values.count(name) != 0; }

private:
    std::map<std::string, hds::SettingValue> _values; ///< set by the application, by name
    std::set<std::string> _toldNotes; ///< on former spellings: each is told once a session
};

PXR_NAMESPACE_CLOSE_SCOPE

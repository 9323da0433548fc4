// SPDX-License-Identifier: Apache-2.0
// Volumes and their fields: a field that changes changes the volumes that have it, of which Hydra
// says nothing.
#pragma once

#include "hdStream/session/session.h"

#include <pxr/pxr.h>
#include <pxr/usd/sdf/path.h>

#include <map>
#include <mutex>
#include <set>
#include <string>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

/// Thread-safe.
class HdStreamVolumeTable {
public:
    struct Volume {
        std::string scenePath;
        hds::VolumePrim prim; ///< without fields
        std::map<std::string, SdfPath> fieldIds;
    };
    /// A volume with its fields.
    struct Edit {
        std::string scenePath;
        hds::VolumePrim prim;
    };

    /// \return the volumes that have the field: they are to be set anew.
    std::vector<Edit> SetField(const SdfPath& id, const hds::VolumeField& field);
    std::vector<Edit> RemoveField(const SdfPath& id);
    Edit SetVolume(const SdfPath& id, Volume volume);
    void RemoveVolume(const SdfPath& id);

private:
    Edit MakeEdit(const Volume& volume) const;
    std::vector<Edit> EditsOf(const SdfPath& fieldId) const;

    mutable std::mutex _mutex;
    std::map<SdfPath, hds::VolumeField> _fields;
    std::map<SdfPath, Volume> _volumes;
};

PXR_NAMESPACE_CLOSE_SCOPE

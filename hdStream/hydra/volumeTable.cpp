// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/volumeTable.h"

#include <algorithm>
#include <utility>

PXR_NAMESPACE_OPEN_SCOPE

HdStreamVolumeTable::Edit HdStreamVolumeTable::MakeEdit(const Volume& volume) const {
    Edit edit{volume.scenePath, volume.prim};
    for (const auto& [name, fieldId] : volume.fieldIds) {
        const auto field = _fields.find(fieldId);
        if (field != _fields.end()) {
            hds::VolumeField& own = edit.prim.fields[name] = field->second;
            own.gridName = own.gridName.empty() ? name : own.gridName;
        }
    }
    return edit;
}

std::vector<HdStreamVolumeTable::Edit> HdStreamVolumeTable::EditsOf(const SdfPath& fieldId) const {
    std::vector<Edit> edits;
    for (const auto& [id, volume] : _volumes) {
        const bool hasIt = std::any_of(volume.fieldIds.begin(), volume.fieldIds.end(),
                                       [&](const auto& entry) { return entry.second == fieldId; });
        if (hasIt) {
            edits.push_back(MakeEdit(volume));
        }
    }
    return edits;
}

std::vector<HdStreamVolumeTable::Edit>
HdStreamVolumeTable::SetField(const SdfPath& id, const hds::VolumeField& field) {
    const std::lock_guard<std::mutex> lock(_mutex);
    const auto [found, isNew] = _fields.emplace(id, field);
    if (!isNew && found->second == field) {
        return {};
    }
    found->second = field;
    return EditsOf(id);
}

std::vector<HdStreamVolumeTable::Edit> HdStreamVolumeTable::RemoveField(const SdfPath& id) {
    const std::lock_guard<std::mutex> lock(_mutex);
    _fields.erase(id);
    return EditsOf(id);
}

HdStreamVolumeTable::Edit HdStreamVolumeTable::SetVolume(const SdfPath& id, Volume volume) {
    const std::lock_guard<std::mutex> lock(_mutex);
    return MakeEdit(_volumes[id] = std::move(volume));
}

void HdStreamVolumeTable::RemoveVolume(const SdfPath& id) {
    const std::lock_guard<std::mutex> lock(_mutex);
    _volumes.erase(id);
}

PXR_NAMESPACE_CLOSE_SCOPE

// SPDX-License-Identifier: Apache-2.0
// Paths of UDIM sets that Hydra hands over as authored. OpenUSD's scene indices do not resolve
// them: no file has the token in its name. What they are relative to is the layer that authors
// them, which is looked for among those that are loaded.
#pragma once

#include <pxr/base/tf/notice.h>
#include <pxr/base/tf/weakBase.h>
#include <pxr/pxr.h>
#include <pxr/usd/sdf/layer.h>
#include <pxr/usd/sdf/notice.h>

#include <cstddef>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

/// Whether a path names a set of tiles.
bool HdStreamIsUdimSet(const std::string& path);

/// HdStreamUdimSets::Resolve of the sets of this process.
std::string HdStreamResolveUdimSet(const std::string& authored);

/// Which loaded layer authors which sets. A layer is read once, and again when it was edited.
/// Thread-safe.
class HdStreamUdimSets : public TfWeakBase {
public:
    HdStreamUdimSets();
    ~HdStreamUdimSets();
    HdStreamUdimSets(const HdStreamUdimSets&) = delete;
    HdStreamUdimSets& operator=(const HdStreamUdimSets&) = delete;

    /// The path of a set, with the token in it, as the first loaded layer means it that authors it
    /// as the value of an attribute and of which there is a tile; by the order of the layers'
    /// identifiers. Empty: there is none.
    std::string Resolve(const std::string& authored);

    /// How many times a layer was read so far.
    std::size_t NumRead() const;

private:
    void _OnEdit(const SdfNotice::LayersDidChange& notice);
    std::vector<SdfLayerHandle> _Find(const std::string& authored);
    std::vector<SdfLayerHandle> _FindKnown(const std::string& authored) const;
    void _Read();

    mutable std::mutex _mutex;
    TfNotice::Key _key;
    std::map<SdfLayerHandle, std::set<std::string>> _setsOf; ///< of each layer that was read
    std::size_t _numRead = 0;
};

PXR_NAMESPACE_CLOSE_SCOPE

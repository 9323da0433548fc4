// SPDX-License-Identifier: Apache-2.0
// The prims of the core's scene that one gprim of Hydra becomes: one, or as many as its instances
// have different values.
#pragma once

#include "hdStream/hydra/instancePrimvars.h"

#include <pxr/pxr.h>
#include <pxr/usd/sdf/path.h>

#include <memory>
#include <string>
#include <vector>

PXR_NAMESPACE_OPEN_SCOPE

class HdStreamRenderParam;

/// Externally synchronised, as the gprim it belongs to.
class HdStreamGeometryVariants {
public:
    /// Makes a variant of each group. Descriptions of groups whose values were there before stay
    /// the same objects while `geometry` does. \return true when variants changed.
    bool Update(const std::shared_ptr<const hds::GeometryDescription>& geometry,
                HdStreamInstanceGroups groups);

    bool IsInScene() const { return _numInScene > 0; }

    /// Queues all variants of a prim, or their removal when it is not drawable.
    /// \param scenePath path of the first variant; the others get paths derived from it.
    void Push(HdStreamRenderParam* param, const SdfPath& id, const std::string& scenePath,
              const hds::GeometryPrim& prim, bool isDrawable);

    /// Removes all from the scene and gives their own paths back; `scenePath` is the gprim's.
    void Finalize(HdStreamRenderParam* param, const std::string& scenePath);

private:
    struct Variant {
        std::vector<hds::Primvar> primvars;
        std::shared_ptr<const hds::GeometryDescription> geometry;
        hds::SharedSpan<std::int32_t> instances;
    };

    void RemoveFrom(HdStreamRenderParam* param, std::size_t first, const std::string& scenePath);
    const std::string& PathOf(std::size_t index, const std::string& scenePath) const {
        return index == 0 ? scenePath : _paths[index - 1];
    }

    std::shared_ptr<const hds::GeometryDescription> _geometry; ///< that variants are made from
    std::vector<Variant> _variants;
    std::vector<std::string> _paths; ///< of the second variant and the next
    std::size_t _numInScene = 0;     ///< the first variants
};

PXR_NAMESPACE_CLOSE_SCOPE

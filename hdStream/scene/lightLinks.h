// SPDX-License-Identifier: Apache-2.0
// Light and shadow links: which prims and instances belong to which categories, as the few
// combinations ("link sets") that there are; which geometry shadow rays may pass for the sake of a
// light. Explained in docs/lights.md.
#pragma once

#include "hdStream/base/log.h"
#include "hdStream/scene/sceneDescription.h"
#include "hdStream/shading/lightTable.h"

#include <map>
#include <optional>
#include <set>
#include <string>

namespace hds {

/// Gives numbers to the combinations of categories as they are met; 0: in none.
class LightLinks final {
public:
    /// Knows the categories that lights name, mesh lights among them; without any nothing else here
    /// costs anything.
    explicit LightLinks(const SceneDescription& scene);

    bool AreUsed() const { return !_indexByCategory.empty(); }

    /// Whether instances of what places the prim are told apart: they need records of their own.
    bool IsLinkedByInstance(const Placement& placement) const;

    /// HDS_INSTANCE_* of geometry in these categories, and in those of its instances: its link set,
    /// and that shadow rays may pass it.
    std::uint32_t FlagsOf(const std::set<std::string>& categories,
                          const std::set<std::string>& ofInstances = {});

    /// The link set alone, of what casts shadows of all lights whatever it is in: volumes.
    std::uint32_t SetOf(const std::set<std::string>& categories,
                        const std::set<std::string>& ofInstances = {});

    /// Gives volumes their sets, before the light table is made of all sets that there are.
    void NumberVolumes();

    /// Whether some geometry casts no shadow of some light, or one that fades.
    bool HaveUnshadowing() const { return _hasUnshadowing; }

    /// Index of a light's category, or HDS_NONE.
    std::uint32_t IndexOf(const std::string& category) const;

    /// All that has been met so far.
    LinkTable Table() const;

    /// One line when there were more combinations than there are numbers.
    void WarnOfOverflow(Warnings& warnings) const;

private:
    /// Of those that lights name.
    using Indices = std::set<std::uint32_t>;

    void AddLight(const LightDescription& light, const LinkCategories& links);
    Indices IndicesOf(const std::set<std::string>& categories,
                      const std::set<std::string>& ofInstances) const;
    /// Nothing: there are too many.
    std::optional<std::uint32_t> NumberOf(const Indices& indices);

    const SceneDescription& _scene;
    std::map<std::string, std::uint32_t> _indexByCategory;
    Indices _shadowCategories;
    std::map<Indices, std::uint32_t> _numberBySet;
    bool _isFading = false; ///< some light's shadows fade: all geometry may be passed
    bool _hasUnshadowing = false;
    bool _isFull = false;
};

} // namespace hds

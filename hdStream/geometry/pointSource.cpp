// SPDX-License-Identifier: Apache-2.0
#include "hdStream/geometry/pointSource.h"

#include "hdStream/geometry/particleSource.h"
#include "kernels/shared/geometry.h"

#include <algorithm>

namespace hds {
namespace {

constexpr float kDefaultWidth = 1.0F; // as Hydra has it

class PointSource final : public ParticleSource {
public:
    PointSource(std::shared_ptr<const GeometryDescription> points, const std::string& primPath,
                Warnings& warnings)
        : ParticleSource(std::move(points), HDS_PRIMITIVE_POINTS, "points", primPath, warnings) {
        if (!CanNumber()) {
            return;
        }
        TopologySize size;
        size.numPoints = size.numFaces = size.numCorners = Count();
        GeometryAttribute widths;
        widths.values = std::vector<float>{kDefaultWidth};
        if (auto authored = AuthoredWidths(*_particles, size, _log)) {
            widths = std::move(*authored);
            WarnBadWidths(widths, _log);
        }
        _widthsOfPoses = WidthsOfPoses(*_particles, widths);
        _values = SolidAttributes(*_particles, size, _log);
        for (const GeometryAttribute& attribute : _values) {
            _attributes.push_back({attribute.name, attribute.numComponents});
        }
        constexpr std::size_t kVertexFloats = 4;
        Measure(kVertexFloats, kVertexFloats, "no width");
    }

private:
    bool IsSeen(std::uint32_t group) const override {
        return std::any_of(
            _widthsOfPoses.begin(), _widthsOfPoses.end(),
            [&](const GeometryAttribute& widths) { return RadiusOf(widths, group) > 0.0F; });
    }
    void Extend(std::uint32_t group, std::size_t pose, Bounds* bounds) const override {
        ExtendBySolid(CentreAt(pose, group), ValueAt(pose, group), bounds);
    }
    float ValueAt(std::size_t pose, std::uint32_t group) const override {
        return RadiusOf(_widthsOfPoses[pose], group);
    }

    std::vector<GeometryAttribute> _widthsOfPoses;
};

} // namespace

std::shared_ptr<const ChunkSource>
MakePointSource(std::shared_ptr<const GeometryDescription> points, const std::string& primPath,
                Warnings& warnings) {
    return std::make_shared<const PointSource>(std::move(points), primPath, warnings);
}

} // namespace hds

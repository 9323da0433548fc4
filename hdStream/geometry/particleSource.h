// SPDX-License-Identifier: Apache-2.0
// What points and splats have in common as sources of chunks: a primitive group is a particle,
// which lies at a point of its own. Internal to geometry. Explained in docs/curves.md.
#pragma once

#include "hdStream/geometry/attributePage.h"
#include "hdStream/geometry/solidContent.h"

#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace hds {

/// Immutable once measured, and thread-safe then.
class ParticleSource : public ChunkSource {
public:
    std::uint32_t GroupTriangles(std::uint32_t group) const override {
        return HasPoint(*_particles, group) && IsSeen(group) ? 1 : 0;
    }
    Bounds GroupBounds(std::uint32_t group) const override;
    ChunkGeometry Gather(const std::uint32_t* groups, std::size_t count) const override;

protected:
    /// \param kind HDS_PRIMITIVE_* \param name what its lines call the particles
    ParticleSource(std::shared_ptr<const GeometryDescription> particles, std::uint32_t kind,
                   const char* name, const std::string& primPath, Warnings& warnings);

    /// Whether there are no more particles than can be numbered; a line where there are.
    bool CanNumber();
    /// Counts and bounds all particles, with a line for those that are dropped.
    /// \param numFloats of a particle in a page. \param numFloatsLater the same at a later key.
    /// \param unseen why particles with a usable point are not drawn.
    void Measure(std::size_t numFloats, std::size_t numFloatsLater, const char* unseen);

    std::size_t Count() const { return _particles->points.size() / 3; }
    std::size_t NumPoses() const { return 1 + _particles->keys.size(); }
    /// Relative to the origin. \pre HasPoint.
    glm::dvec3 CentreAt(std::size_t pose, std::uint32_t group) const {
        return glm::dvec3(*FindPointAt(*_particles, pose, group)) - _origin;
    }

    /// Whether there is something to see, wherever it is.
    virtual bool IsSeen(std::uint32_t group) const = 0;
    /// \pre GroupTriangles, as of the others.
    virtual void Extend(std::uint32_t group, std::size_t pose, Bounds* bounds) const = 0;
    /// What a page has beside the centre.
    virtual float ValueAt(std::size_t pose, std::uint32_t group) const = 0;
    /// Adds what else pages have of it, in all poses.
    virtual void AddShape(std::uint32_t /*group*/, ChunkGeometry* /*chunk*/) const {}

    std::shared_ptr<const GeometryDescription> _particles;
    mutable PrimLog _log;
    std::vector<GeometryAttribute> _values; ///< primvars of pages
    std::uint32_t _kind;                    ///< HDS_PRIMITIVE_*

private:
    void Add(std::uint32_t group, std::size_t pose, std::vector<glm::vec3>* positions,
             std::vector<float>* values, std::vector<Bounds>* bounds) const;

    std::string _name;
    mutable std::once_flag _isRead;
};

} // namespace hds

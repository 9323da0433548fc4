// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/dicingViews.h"

#include "hdStream/geometry/subdivSource.h"
#include "hdStream/scene/motion.h"
#include "hdStream/scene/placements.h"

#include "kernels/shared/geometry.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <glm/matrix.hpp>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace hds {

namespace {

/// Instancers that place each other in a circle place nothing.
constexpr int kMaxChain = 64;

struct Sphere {
    glm::dvec3 centre{0.0};
    double radius = -1.0; ///< negative: empty
};

/// Matrices at the frame and, of what moves, at the ends of the steps of the shutter.
struct Way {
    glm::dmat4 atFrame{1.0};
    std::vector<glm::dmat4> steps; ///< empty: it rests

    bool Moves() const { return !steps.empty(); }
    const glm::dmat4& At(std::size_t step) const { return Moves() ? steps[step] : atFrame; }
};

Way operator*(const Way& outer, const Way& inner) {
    Way product{outer.atFrame * inner.atFrame, {}};
    for (std::size_t i = 0; i <= kDicingSteps && (outer.Moves() || inner.Moves()); ++i) {
        product.steps.push_back(outer.At(i) * inner.At(i));
    }
    return product;
}

double TimeOf(std::size_t step) {
    return double(step) / double(kDicingSteps);
}

Way WayOf(const Placement& placement, const Shutter& shutter) {
    const MovingTransform moving(placement.worldFromObject, placement.samples, shutter);
    Way way{placement.worldFromObject, {}};
    for (std::size_t i = 0; i <= kDicingSteps && moving.Moves(); ++i) {
        way.steps.push_back(moving.At(TimeOf(i)));
    }
    return way;
}

/// The instances of an instancer. They may be many, so between samples they go straight.
class InstanceWays {
public:
    InstanceWays(const InstancerPrim& instancer, const Shutter& shutter)
        : _transforms(instancer.instanceTransforms) {
        std::vector<const InstanceSample*> samples;
        for (const InstanceSample& sample : instancer.samples) {
            if (sample.transforms.size() == 16 * _transforms.Size()) {
                samples.push_back(&sample);
            }
        }
        for (std::size_t i = 0; i <= kDicingSteps && shutter.IsOpen() && samples.size() > 1; ++i) {
            const double time = shutter.open + TimeOf(i) * (shutter.close - shutter.open);
            std::size_t after = 1;
            while (after + 1 < samples.size() && samples[after]->time < time) {
                ++after;
            }
            const InstanceSample& from = *samples[after - 1];
            const InstanceSample& to = *samples[after];
            const double part = (time - from.time) / (to.time - from.time);
            _between.push_back({&from, &to, glm::clamp(part, 0.0, 1.0)});
        }
    }

    Way At(std::size_t index) const {
        Way way{_transforms.At(index), {}};
        for (const Between& between : _between) {
            const glm::dmat4 from = MatrixOf(*between.from, index);
            way.steps.push_back(from + between.part * (MatrixOf(*between.to, index) - from));
        }
        const auto isFirst = [&](const glm::dmat4& step) { return step == way.steps.front(); };
        if (std::all_of(way.steps.begin(), way.steps.end(), isFirst)) {
            way.steps.clear();
        }
        return way;
    }

private:
    struct Between {
        const InstanceSample* from;
        const InstanceSample* to;
        double part;
    };
    static glm::dmat4 MatrixOf(const InstanceSample& sample, std::size_t index) {
        return glm::make_mat4(sample.transforms.data() + 16 * index);
    }

    const InstanceTransforms& _transforms;
    std::vector<Between> _between; ///< by the ends of steps; empty: all rest
};

/// Around the box of the mesh's points, in object space.
Sphere SphereOf(const GeometryPrim& prim) {
    glm::dvec3 low(1e300);
    glm::dvec3 high(-1e300);
    const SharedSpan<float> points = prim.geometry->points.Held();
    for (std::size_t i = 0; i + 2 < points.size(); i += 3) {
        const glm::dvec3 p(points[i], points[i + 1], points[i + 2]);
        if (std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z)) {
            low = glm::min(low, p);
            high = glm::max(high, p);
        }
    }
    if (low.x > high.x) {
        return {};
    }
    return {0.5 * (low + high), 0.5 * glm::length(high - low)};
}

Sphere Placed(const Sphere& sphere, const glm::dmat4& matrix) {
    if (sphere.radius < 0.0) {
        return {};
    }
    const glm::dmat3 linear(matrix);
    // The lengths of a matrix's columns bound it: |M x| <= sqrt(sum of squares) |x|.
    const double scale = std::sqrt(glm::dot(linear[0], linear[0]) + glm::dot(linear[1], linear[1]) +
                                   glm::dot(linear[2], linear[2]));
    return {glm::dvec3(matrix * glm::dvec4(sphere.centre, 1.0)), sphere.radius * scale};
}

void Extend(Sphere& sphere, const Sphere& other) {
    if (other.radius < 0.0) {
        return;
    }
    if (sphere.radius < 0.0) {
        sphere = other;
        return;
    }
    sphere.radius =
        std::max(sphere.radius, glm::length(other.centre - sphere.centre) + other.radius);
}

/// Calls visit(worldFromPrototype) for each instance that a placement names, parents first; once,
/// with the identity, for what is not instanced.
void ForEachInstance(const SceneDescription& scene, const Placement& placement,
                     const Shutter& shutter, int chain,
                     const std::function<void(const Way&)>& visit) {
    if (placement.instancerPath.empty()) {
        visit(Way());
        return;
    }
    const auto found = scene.instancers.find(placement.instancerPath);
    if (found == scene.instancers.end() || !found->second.placement.visible || chain >= kMaxChain) {
        return;
    }
    int length = 0;
    if (chain == 0 && NumPlacements(scene, placement, &length) > kMostPlacements &&
        length > HDS_MAX_GROUP_DEPTH) {
        return; // not drawn, of which scene/hierarchy warns
    }
    const InstancerPrim& instancer = found->second;
    const std::size_t limit = instancer.instanceTransforms.Size();
    const Way parentFromInstancer = WayOf(instancer.placement, shutter);
    const InstanceWays instances(instancer, shutter);
    ForEachInstance(scene, instancer.placement, shutter, chain + 1, [&](const Way& parent) {
        const Way worldFromInstancer = parent * parentFromInstancer;
        for (const std::int32_t index : placement.instances) {
            if (index >= 0 && std::size_t(index) < limit) {
                visit(worldFromInstancer * instances.At(std::size_t(index)));
            }
        }
    });
}

/// How fine an instance is, and whether the image shows it.
struct Fineness {
    bool isOnScreen = false;
    double pixels = -1.0;    ///< of a unit length of the prototype, at its nearest
    double distance = 1e300; ///< of the centre, in radii: of equals the nearer one is finer

    bool operator<(const Fineness& other) const {
        if (isOnScreen != other.isOnScreen) {
            return other.isOnScreen;
        }
        return pixels != other.pixels ? pixels < other.pixels : distance > other.distance;
    }
};

/// A pose of an instance as the camera sees it.
struct Rating {
    std::uint32_t sidesBeyond = 0; ///< sides of the image that it lies beyond, as bits
    bool isClose = false;          ///< the eye is in the sphere, which says nothing then
    double pixels = -1.0;          ///< as Fineness has it, and the next
    double distance = 1e300;

    Fineness At() const { return {sidesBeyond == 0, pixels, distance}; }
};

/// What a moving camera adds to the places of things at rest: at most
/// shift + turn * their distance from the eye, in camera space.
struct CameraWay {
    double shift = 0.0;
    double turn = 0.0;
};

Rating Rate(const glm::dmat4& cameraFromPrototype, const Sphere& sphere, const DicingCamera& camera,
            const CameraWay& way = {}) {
    const glm::dmat3 linear(cameraFromPrototype);
    const double square = std::max({glm::dot(linear[0], linear[0]), glm::dot(linear[1], linear[1]),
                                    glm::dot(linear[2], linear[2])});
    const double scale = std::sqrt(square);
    // Columns bound a matrix up to the square root of their number.
    double radius = std::max(sphere.radius, 0.0) * scale * std::sqrt(3.0);
    const auto centre = glm::dvec3(cameraFromPrototype * glm::dvec4(sphere.centre, 1.0));
    radius += way.shift + way.turn * (glm::length(centre) + radius);
    const double distance = camera.isPanoramic ? glm::length(centre) : -centre.z;
    Rating rating;
    rating.pixels =
        camera.isOrthographic ? scale : scale / std::max(distance - radius, camera.nearClip);
    rating.isClose = !camera.isOrthographic && distance - radius <= camera.nearClip;
    rating.distance = glm::length(centre) / std::max(radius, 1e-300);
    if (camera.isPanoramic) {
        return rating;
    }
    rating.sidesBeyond = centre.z - radius <= 0.0 ? 0 : 16;
    for (int axis = 0; axis < 2; ++axis) {
        for (const double side : {-1.0, 1.0}) {
            const double border = side < 0.0 ? camera.windowMin[axis] : camera.windowMax[axis];
            // Outside of the border's plane, through the eye unless orthographic.
            const double depth = camera.isOrthographic ? 1.0 : -centre.z;
            const double length = camera.isOrthographic ? 1.0 : std::sqrt(1.0 + border * border);
            if (side * (centre[axis] - border * depth) / length > radius) {
                rating.sidesBeyond |= 1U << (2 * axis + (side < 0.0 ? 0 : 1));
            }
        }
    }
    return rating;
}

/// A prim of a group, and the best that was found for it.
struct Member {
    const GeometryEntry* entry = nullptr;
    Way prototypeFromObject;
    std::vector<Sphere> spheres; ///< in the prototype: at the frame, then at steps if it moves

    Fineness finest;
    std::vector<glm::dmat4> poses; ///< camera from prototype and object, the finest one first
    std::size_t numOnScreen = 0;
    /// Instances whose sphere says little, the nearest first.
    std::vector<std::pair<double, glm::dmat4>> close;

    const Sphere& SphereAt(std::size_t step) const {
        return spheres[spheres.size() > 1 ? 1 + step : 0];
    }
};

/// Prims with the same instances.
struct Group {
    const Placement* placement = nullptr;
    std::vector<Member> members;
};

/// Places of one prim that are measured, at most.
constexpr std::size_t kMostPlaces = 8;
/// How far a place may be beside a straight way, as a part of it.
constexpr double kStraight = 1.0 / 256.0;

/// The search for the views of a group.
class ViewSearch {
public:
    ViewSearch(const DicingCamera& camera, Group& group)
        : _camera(camera), _group(group), _cameraFromWorld(glm::inverse(camera.worldFromCamera)) {
        for (const glm::dmat4& pose : camera.path) {
            _pathFromWorld.push_back(glm::inverse(pose));
            const glm::dmat4 moved = _pathFromWorld.back() * camera.worldFromCamera;
            const glm::dmat3 turn = glm::dmat3(moved) - glm::dmat3(1.0);
            _way.shift = std::max(_way.shift, glm::length(glm::dvec3(moved[3])));
            _way.turn = std::max(_way.turn,
                                 std::sqrt(glm::dot(turn[0], turn[0]) + glm::dot(turn[1], turn[1]) +
                                           glm::dot(turn[2], turn[2])));
        }
        for (const Member& member : group.members) {
            Extend(_sphere, member.spheres.front());
            _membersMove = _membersMove || member.prototypeFromObject.Moves();
        }
    }

    void Visit(const Way& worldFromPrototype) {
        const glm::dmat4 cameraFromPrototype = _cameraFromWorld * worldFromPrototype.atFrame;
        const bool areStill = !_membersMove && !worldFromPrototype.Moves();
        const bool moves = !areStill || !_pathFromWorld.empty();
        if (areStill && (moves || _group.members.size() > 1) &&
            IsNothingNew(Rate(cameraFromPrototype, _sphere, _camera, _way))) {
            return;
        }
        for (Member& member : _group.members) {
            if (moves) {
                VisitMoving(worldFromPrototype, member);
                continue;
            }
            const Rating rating = Rate(cameraFromPrototype, member.spheres.front(), _camera);
            const auto pose = [&] {
                return cameraFromPrototype * member.prototypeFromObject.atFrame;
            };
            Note(rating, pose, member);
            if (member.finest < rating.At()) {
                member.finest = rating.At();
                member.poses.assign(1, pose());
            }
        }
    }

private:
    /// Whether no prim in the sphere of the group can be finer than what was found, or closer.
    bool IsNothingNew(const Rating& rating) const {
        Fineness most = rating.At();
        most.distance = 1e300; // of another sphere
        return !(most.isOnScreen && rating.isClose) &&
               std::none_of(
                   _group.members.begin(), _group.members.end(), [&](const Member& member) {
                       return member.finest < most || (most.isOnScreen && member.numOnScreen < 2);
                   });
    }

    template <typename PoseOf>
    void Note(const Rating& rating, const PoseOf& poseOf, Member& member) const {
        if (rating.sidesBeyond != 0) {
            return;
        }
        ++member.numOnScreen;
        auto& close = member.close;
        if (!rating.isClose ||
            (close.size() == kMostPlaces && !(rating.distance < close.back().first))) {
            return;
        }
        const auto after = std::find_if(close.begin(), close.end(), [&](const auto& other) {
            return rating.distance < other.first;
        });
        close.insert(after, {rating.distance, poseOf()});
        close.resize(std::min(close.size(), kMostPlaces));
    }

    void VisitMoving(const Way& worldFromPrototype, Member& member) const {
        Rating whole;
        whole.sidesBeyond = ~0U;
        std::size_t finest = 0;
        std::vector<glm::dmat4> poses;
        poses.reserve(kDicingSteps + 2);
        const auto rate = [&](const glm::dmat4& cameraFromPrototype, const Sphere& sphere,
                              const glm::dmat4& prototypeFromObject) {
            const Rating rating = Rate(cameraFromPrototype, sphere, _camera);
            if (whole.pixels < rating.pixels) {
                whole.pixels = rating.pixels;
                finest = poses.size();
            }
            // On a straight way past one side nothing comes into the image.
            whole.sidesBeyond &= rating.sidesBeyond;
            whole.isClose = whole.isClose || rating.isClose;
            whole.distance = std::min(whole.distance, rating.distance);
            poses.push_back(cameraFromPrototype * prototypeFromObject);
        };
        for (std::size_t i = 0; i <= kDicingSteps; ++i) {
            const glm::dmat4& cameraFromWorld =
                _pathFromWorld.empty() ? _cameraFromWorld : _pathFromWorld[i];
            rate(cameraFromWorld * worldFromPrototype.At(i), member.SphereAt(i),
                 member.prototypeFromObject.At(i));
        }
        rate(_cameraFromWorld * worldFromPrototype.atFrame, member.spheres.front(),
             member.prototypeFromObject.atFrame);
        Note(
            whole, [&] { return poses[finest]; }, member);
        if (member.finest < whole.At()) {
            member.finest = whole.At();
            member.poses = Thinned(std::move(poses), finest, member);
        }
    }

    /// The finest place, then the others: of a straight way its ends.
    static std::vector<glm::dmat4> Thinned(std::vector<glm::dmat4> poses, std::size_t finest,
                                           const Member& member) {
        const Sphere sphere = member.spheres.front();
        const double size = std::max(glm::length(sphere.centre) + sphere.radius, 0.0);
        const auto weighed = [&](glm::dmat4 matrix) { // so that entries are lengths
            for (int column = 0; column < 3; ++column) {
                matrix[column] *= size;
            }
            return matrix;
        };
        const auto product = [](const glm::dmat4& a, const glm::dmat4& b) {
            return glm::dot(a[0], b[0]) + glm::dot(a[1], b[1]) + glm::dot(a[2], b[2]) +
                   glm::dot(a[3], b[3]);
        };
        const glm::dmat4 way = weighed(poses[kDicingSteps] - poses[0]);
        const double square = product(way, way);
        const bool isStraight = std::all_of(poses.begin(), poses.end(), [&](const auto& pose) {
            const glm::dmat4 from = weighed(pose - poses[0]);
            const double part = square > 0.0 ? product(from, way) / square : 0.0;
            const glm::dmat4 beside = from - glm::clamp(part, 0.0, 1.0) * way;
            return product(beside, beside) <= kStraight * kStraight * square;
        });
        std::vector<glm::dmat4> places{poses[finest]};
        for (std::size_t i = 0; i < poses.size(); ++i) {
            const bool isEnd = i == 0 || i == kDicingSteps;
            if ((isEnd || !isStraight) &&
                std::find(places.begin(), places.end(), poses[i]) == places.end()) {
                places.push_back(poses[i]);
            }
        }
        return places;
    }

    const DicingCamera& _camera;
    Group& _group;
    glm::dmat4 _cameraFromWorld;
    std::vector<glm::dmat4> _pathFromWorld;
    Sphere _sphere; ///< around the prims at rest
    CameraWay _way;
    bool _membersMove = false;
};

DicingView ViewOf(const DicingCamera& camera, const Member& member) {
    DicingView view;
    view.isOrthographic = camera.isOrthographic;
    view.isPanoramic = camera.isPanoramic;
    view.windowMin = camera.windowMin;
    view.windowMax = camera.windowMax;
    view.imageSize = camera.imageSize;
    view.nearClip = camera.nearClip;
    view.isOnlyInstance = camera.isStill && member.numOnScreen <= 1;
    if (member.poses.empty()) { // nothing places it
        view.cameraFromObject =
            glm::inverse(camera.worldFromCamera) * member.prototypeFromObject.atFrame;
        return view;
    }
    view.cameraFromObject = member.poses.front();
    view.otherPlaces.assign(member.poses.begin() + 1, member.poses.end());
    for (const auto& [distance, pose] : member.close) {
        const bool isKnown =
            std::find(member.poses.begin(), member.poses.end(), pose) != member.poses.end();
        if (member.numOnScreen > 1 && !isKnown) {
            view.otherPlaces.push_back(pose);
        }
    }
    return view;
}

Member MakeMember(const GeometryEntry& entry, const Shutter& shutter,
                  const DisplacementReach& reachOf) {
    const Placement& placement = entry.second.placement;
    Member member;
    member.entry = &entry;
    member.prototypeFromObject = WayOf(placement, shutter);
    Sphere sphere = SphereOf(entry.second);
    if (reachOf && sphere.radius >= 0.0 && !placement.instancerPath.empty()) {
        sphere.radius += reachOf(entry);
    }
    member.spheres.push_back(Placed(sphere, member.prototypeFromObject.atFrame));
    for (const glm::dmat4& step : member.prototypeFromObject.steps) {
        member.spheres.push_back(Placed(sphere, step));
    }
    return member;
}

} // namespace

std::map<std::string, DicingView> FindDicingViews(const SceneDescription& scene,
                                                  const std::vector<const GeometryEntry*>& prims,
                                                  const DicingCamera& camera,
                                                  const Shutter& shutter,
                                                  const DisplacementReach& reachOf) {
    std::map<std::pair<std::string, const std::int32_t*>, std::size_t> index;
    std::vector<Group> groups;
    std::vector<std::vector<const GeometryEntry*>> entries;
    const auto addGroup = [&](const Placement& placement) {
        groups.push_back({&placement, {}});
        entries.emplace_back();
    };
    for (const GeometryEntry* entry : prims) {
        const GeometryPrim& prim = entry->second;
        if (!IsSubdivisionScheme(prim.geometry->subdivisionScheme)) {
            continue;
        }
        const Placement& placement = prim.placement;
        // What is not instanced is a group of its own: its matrix is a placement of one.
        if (placement.instancerPath.empty()) {
            addGroup(placement);
            entries.back().push_back(entry);
            continue;
        }
        const auto [found, isNew] = index.emplace(
            std::make_pair(placement.instancerPath, placement.instances.data()), groups.size());
        if (isNew) {
            addGroup(placement);
        }
        entries[found->second].push_back(entry);
    }
    std::map<std::string, DicingView> result;
    for (const auto& members : entries) {
        for (const GeometryEntry* entry : members) {
            result[entry->first] = {};
        }
    }
    tbb::parallel_for(std::size_t{0}, groups.size(), [&](std::size_t i) {
        Group& group = groups[i];
        for (const GeometryEntry* entry : entries[i]) {
            group.members.push_back(MakeMember(*entry, shutter, reachOf));
        }
        ViewSearch search(camera, group);
        ForEachInstance(scene, *group.placement, shutter, 0,
                        [&](const Way& instance) { search.Visit(instance); });
        for (const Member& member : group.members) {
            result.at(member.entry->first) = ViewOf(camera, member);
        }
    });
    return result;
}

} // namespace hds

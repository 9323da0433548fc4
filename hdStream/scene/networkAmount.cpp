// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/networkAmount.h"

#include "hdStream/scene/networkValues.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

namespace hds {

namespace {

class NetworkAmount : public DisplacementAmount {
public:
    explicit NetworkAmount(DisplacementNetwork network) : _network(std::move(network)) {
        for (const DisplacementPrimvar& primvar : _network.primvars) {
            AmountPrimvar& added = _primvars.emplace_back();
            added.names = primvar.names;
            added.numComponents = primvar.numComponents;
            std::copy(primvar.missing.begin(), primvar.missing.end(), added.missing.begin());
        }
        _readsPosition = hds::ReadsPosition(_network);
    }

    const std::vector<AmountPrimvar>& Primvars() const override { return _primvars; }
    bool ReadsPosition() const override { return _readsPosition; }

    DisplacementSpace Space() const override {
        if (!_network.isVector) {
            return DisplacementSpace::Normal;
        }
        return _network.coordinates == HDS_NONE ? DisplacementSpace::Object
                                                : DisplacementSpace::Tangent;
    }
    std::size_t Coordinates() const override { return _network.coordinates; }

    double At(const AmountPoint& point) const override {
        return _network.isVector ? 0.0 : Finite(ValueOf(_network, point)[0]);
    }
    glm::dvec3 VectorAt(const AmountPoint& point) const override {
        if (!_network.isVector) {
            return glm::dvec3(0.0);
        }
        const NetworkValue result = ValueOf(_network, point);
        return {Finite(result[0]), Finite(result[1]), Finite(result[2])};
    }

    AmountRange Over(const AmountBox& box) const override {
        const ValueRange results = RangeOf(_network, box);
        if (_network.isVector) {
            glm::dvec3 most(0.0);
            for (glm::length_t k = 0; k < 3; ++k) {
                const AmountRange& one = results[static_cast<std::size_t>(k)];
                most[k] = std::max(std::fabs(one.low), std::fabs(one.high));
            }
            const double length = glm::length(most);
            return {-length, length};
        }
        const AmountRange range = results[0];
        // What is not finite is 0.
        return std::isfinite(range.low) && std::isfinite(range.high) ? range
                                                                     : HullOf(range, {0.0, 0.0});
    }

private:
    static double Finite(float value) {
        return std::isfinite(value) ? static_cast<double>(value) : 0.0;
    }

    DisplacementNetwork _network;
    std::vector<AmountPrimvar> _primvars;
    bool _readsPosition = false;
};

} // namespace

std::shared_ptr<const DisplacementAmount> MakeNetworkAmount(DisplacementNetwork network) {
    return std::make_shared<NetworkAmount>(std::move(network));
}

} // namespace hds

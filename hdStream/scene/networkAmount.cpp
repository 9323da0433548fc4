// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/networkAmount.h"

#include "hdStream/scene/networkValues.h"

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

    double At(const AmountPoint& point) const override {
        const auto result = static_cast<double>(ValueOf(_network, point)[0]);
        return std::isfinite(result) ? result : 0.0;
    }

    AmountRange Over(const AmountBox& box) const override {
        const AmountRange range = RangeOf(_network, box)[0];
        // What is not finite is 0.
        return std::isfinite(range.low) && std::isfinite(range.high) ? range
                                                                     : HullOf(range, {0.0, 0.0});
    }

private:
    DisplacementNetwork _network;
    std::vector<AmountPrimvar> _primvars;
    bool _readsPosition = false;
};

} // namespace

std::shared_ptr<const DisplacementAmount> MakeNetworkAmount(DisplacementNetwork network) {
    return std::make_shared<NetworkAmount>(std::move(network));
}

} // namespace hds

// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/meshKey.h"

#include "hdStream/base/fieldHash.h"

namespace hds {

PageKey MakeMeshKey(const GeometryInputs& inputs) {
    Hasher hasher;
    FieldHasher fields(&hasher);
    fields.Add(inputs);
    if (inputs.shutter.IsOpen()) {
        fields.Add(inputs.mesh->samples);
    }
    return MakePageKey(hasher);
}

} // namespace hds

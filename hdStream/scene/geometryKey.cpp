// SPDX-License-Identifier: Apache-2.0
#include "hdStream/scene/geometryKey.h"

#include "hdStream/base/fieldHash.h"

namespace hds {

PageKey MakeGeometryKey(const GeometryInputs& inputs) {
    Hasher hasher;
    FieldHasher fields(&hasher);
    fields.Add(inputs);
    if (inputs.shutter.IsOpen()) {
        fields.Add(inputs.geometry->samples);
        fields.Add(inputs.geometry->widthSamples);
        fields.Add(inputs.geometry->normalSamples);
        fields.Add(inputs.geometry->splatSamples);
    }
    return MakePageKey(hasher);
}

} // namespace hds

// SPDX-License-Identifier: Apache-2.0
#include "hdStream/integrator/frameConstants.h"

#include "hdStream/integrator/cameraFrame.h"
#include "hdStream/integrator/lightPathTable.h"
#include "hdStream/shading/pixelFilter.h"

#include <vector>

namespace hds {

namespace {

shared::HdsFrameParams ParamsOf(const RenderOptions& options, const CommittedScene& scene) {
    shared::HdsFrameParams params = MakeFrameParams(
        options, scene.centre, static_cast<std::uint32_t>(scene.lights->lights.size()));
    params.probeLength = MediaProbeLength(params, scene.mediaBounds, scene.hasMotion);
    return params;
}

} // namespace

void FrameConstants::Ready(const RenderOptions& options, const CommittedScene& scene) {
    std::vector<std::uint32_t> table;
    if (!options.aovs.lightPaths.empty()) {
        table =
            MakeLightPathTable(CompileLightPaths(options.aovs.lightPaths), scene.lights->groups);
    }
    const std::uint64_t tableBytes = table.size() * sizeof(table[0]);
    const std::uint64_t bytes = sizeof(shared::HdsFrameParams) + tableBytes;
    if (!_frame.IsValid() || _frame.Bytes() != bytes) {
        _frame = Buffer(_device, "frame constants", bytes, BufferAccess::ReadOnly);
    }
    SetOptions(options, scene);
    if (tableBytes > 0) {
        _frame.Write(table.data(), tableBytes, sizeof(shared::HdsFrameParams));
    }
    const std::pair<std::string, double> shape(options.pixelFilter, options.pixelFilterWidth);
    if (_filterShape != shape) {
        _filter =
            UploadVector(_device, "pixel filter", BuildPixelFilterTable(shape.first, shape.second));
        _filterShape = shape;
    }
}

void FrameConstants::SetOptions(const RenderOptions& options, const CommittedScene& scene) {
    const shared::HdsFrameParams params = ParamsOf(options, scene);
    _frame.Write(&params, sizeof(params));
    _camera = {params.worldFromCamera[3], params.worldFromCamera[7], params.worldFromCamera[11]};
}

} // namespace hds

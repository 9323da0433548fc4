// SPDX-License-Identifier: Apache-2.0
// What kernels know of a render: its constants, with the table of its light path expressions behind
// them, and the pixel filter.
#pragma once

#include "hdStream/device/device.h"
#include "hdStream/integrator/renderOptions.h"
#include "hdStream/scene/commit.h"
#include "kernels/shared/frame.h"

#include <array>
#include <memory>
#include <string>
#include <utility>

namespace hds {

/// Externally synchronised.
class FrameConstants {
public:
    explicit FrameConstants(std::shared_ptr<Device> device) : _device(std::move(device)) {}

    /// Makes all of it for a render. \throws Error when memory runs out.
    void Ready(const RenderOptions& options, const CommittedScene& scene);
    /// Exchanges the constants for those of options that differ in camera, image or seed alone.
    void SetOptions(const RenderOptions& options, const CommittedScene& scene);

    /// Of the present constants, relative to the scene centre.
    std::array<float, 3> CameraPosition() const { return _camera; }
    const Buffer& Frame() const { return _frame; }
    const Buffer& Filter() const { return _filter; }

private:
    std::shared_ptr<Device> _device;
    Buffer _frame;
    Buffer _filter;
    std::array<float, 3> _camera{};
    std::pair<std::string, double> _filterShape; ///< name and width of `_filter`
};

} // namespace hds

// SPDX-License-Identifier: Apache-2.0
#include "hdStream/texture/colorConversion.h"

#include "hdStream/texture/colorConfig.h"

namespace OCIO = OCIO_NAMESPACE;

namespace hds {

namespace {

constexpr char kArrow = '>';

} // namespace

struct ColorConversion::Processor {
    OCIO::ConstCPUProcessorRcPtr cpu; ///< null: identity
};

std::string JoinConversion(const std::string& from, const std::string& to) {
    return from + kArrow + to;
}

ColorConversionName SplitConversion(const std::string& name) {
    const std::size_t arrow = name.find(kArrow);
    if (arrow == std::string::npos) {
        return {name, ""};
    }
    return {name.substr(0, arrow), name.substr(arrow + 1)};
}

bool IsDataSpace(const std::string& space) {
    if (space.empty() || space == "auto" || space == "none") {
        return true;
    }
    OCIO::ConstColorSpaceRcPtr known = ColorConfig()->getColorSpace(space.c_str());
    if (!known) {
        known = BuiltInColorConfig()->getColorSpace(space.c_str());
    }
    return known && known->isData();
}

bool IsColorSpace(const std::string& name) {
    return ColorConfig()->getColorSpace(name.c_str()) != nullptr ||
           BuiltInColorConfig()->getColorSpace(name.c_str()) != nullptr;
}

ColorConversion::ColorConversion(const std::string& from, const std::string& to)
    : _processor(std::make_unique<Processor>()) {
    const std::string target = to.empty() ? OCIO::ROLE_SCENE_LINEAR : to;
    _processor->cpu = MakeColorProcessor(from, target);
    if (_processor->cpu->isNoOp()) {
        _processor->cpu.reset();
    }
}

ColorConversion::~ColorConversion() = default;

bool ColorConversion::IsIdentity() const {
    return !_processor->cpu;
}

void ColorConversion::Apply(float* rgb, std::size_t numColors, std::size_t stride) const {
    if (!_processor->cpu || numColors == 0) {
        return;
    }
    OCIO::PackedImageDesc pixels(rgb, static_cast<long>(numColors), 1, 3, OCIO::BIT_DEPTH_F32,
                                 sizeof(float), static_cast<std::ptrdiff_t>(stride * sizeof(float)),
                                 static_cast<std::ptrdiff_t>(numColors * stride * sizeof(float)));
    _processor->cpu->apply(pixels);
}

} // namespace hds

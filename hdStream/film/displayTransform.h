// SPDX-License-Identifier: Apache-2.0
// From linear working-space colour to a display's encoded values, as usdrecord's
// --colorCorrectionMode names it.
// Explained in docs/film.md.
#pragma once

#include <cstddef>
#include <memory>
#include <string>

namespace hds {

/// usdrecord's modes, and the default of `hdstream record`.
enum class ColorCorrection {
    Automatic,   ///< OpenColorIO when $OCIO is set, else sRGB
    Disabled,    ///< linear values as they are
    Srgb,        ///< the sRGB transfer function (srgb.h)
    OpenColorIO, ///< default display and view of the configuration (colorConfig.h)
};

/// Reads "disabled", "sRGB", "openColorIO" or "" (automatic).
/// \throws Error (Usage) that names the option
ColorCorrection ParseColorCorrection(const std::string& mode);

/// A display transform. Immutable after construction, thread-safe.
class DisplayTransform {
public:
    /// \param workingSpace that colours are in; empty: the configuration's scene_linear role (mode
    ///        Srgb: linear Rec.709)
    /// \throws Error when the OpenColorIO configuration has no usable default display
    explicit DisplayTransform(ColorCorrection mode, const std::string& workingSpace = "");
    ~DisplayTransform();

    /// Transforms RGB triples in place. Values are not clamped.
    void Apply(float* rgb, std::size_t numPixels) const;

    /// Whether the result is linear (mode Disabled).
    bool IsLinear() const { return _mode == ColorCorrection::Disabled; }

private:
    struct Processor;
    ColorCorrection _mode;
    std::unique_ptr<Processor> _processor; ///< of OpenColorIO; before the sRGB function
};

} // namespace hds

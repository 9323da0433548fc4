// SPDX-License-Identifier: Apache-2.0
// Colours from one space to another, and how a texture's request names both: "FROM>TO".
// Explained in docs/color.md.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace hds {

/// FROM of an image of colours that names no space: its codes are sRGB where "auto" says so, else
/// they are linear Rec.709 (where "auto" stands alone, numbers that are not sRGB are data).
constexpr const char* kAutoColor = "autoColor";

/// A request's colour space taken apart.
struct ColorConversionName {
    std::string from;
    std::string to; ///< empty: the working space is the configuration's scene_linear role
};

std::string JoinConversion(const std::string& from, const std::string& to);
ColorConversionName SplitConversion(const std::string& name);

/// Whether values of a space are no colours, or of none that is known by name (raw, data, auto):
/// they stay as they are.
bool IsDataSpace(const std::string& space);

/// Whether the configuration in force, or the built-in one, has a space of that name.
/// \throws Error as ColorConfig
bool IsColorSpace(const std::string& name);

/// What the configuration in force is made of.
struct ColorConfigSources {
    std::vector<std::string> files; ///< its own, and those of its tables
    /// $OCIO where it is no file, and what its transforms name, with the values of variables
    std::vector<std::string> words;
};

/// After RefreshColorConfig. Thread-safe.
/// \throws Error as ColorConfig
ColorConfigSources FindColorConfigSources();

/// A text that is another one for another configuration: for other words or, by path, size, date
/// and their ends, for other files than it was loaded with. Thread-safe. \throws Error as
/// ColorConfig
std::string ColorConfigIdentity();

/// Has the configuration loaded again where a file of it has changed since it was loaded. What
/// holds the old one keeps it. Thread-safe.
void RefreshColorConfig();

/// Colours from one space to another. Immutable after construction, thread-safe.
class ColorConversion {
public:
    /// \param to empty: the configuration's scene_linear role
    /// \throws std::exception when a name is unknown, or there is no way between the two
    ColorConversion(const std::string& from, const std::string& to);
    ~ColorConversion();

    /// Whether all colours stay as they are, to the bit.
    bool IsIdentity() const;

    /// Converts colours in place. \param stride floats from one to the next, 3 at least
    void Apply(float* rgb, std::size_t numColors, std::size_t stride = 3) const;

private:
    struct Processor;
    std::unique_ptr<Processor> _processor;
};

} // namespace hds

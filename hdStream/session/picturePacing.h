// SPDX-License-Identifier: Apache-2.0
// When the next picture of a render is due. It knows no clock: seconds are told. Explained in
// docs/session.md.
#pragma once

#include <cstdint>

namespace hds {

/// Pictures follow each other some time apart, and so that making them takes a small part of it. A
/// finer stride of the first picture (Progress::previewStride) is due at once.
class PicturePacing {
public:
    /// \param interval seconds from the end of one picture to the next, at least.
    explicit PicturePacing(double interval) : _interval(interval) {}

    /// Whether a picture of that stride is to be made now.
    bool IsDue(double now, std::uint32_t stride) const { return stride != _stride || now >= _next; }
    /// A picture of that stride was made.
    void Made(double begin, double end, std::uint32_t stride);
    /// Of the last picture; 0: there is none yet.
    std::uint32_t Stride() const { return _stride; }

private:
    double _interval;
    double _next = 0.0;
    std::uint32_t _stride = 0;
};

} // namespace hds

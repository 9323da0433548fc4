// SPDX-License-Identifier: Apache-2.0
// Denoising by Open Image Denoise (https://www.openimagedenoise.org), which is looked for when it
// is wanted: nothing is linked, and no build needs it. Explained in docs/denoising.md.
#pragma once

#include "hdStream/film/imageLayer.h"

#include <memory>
#include <string>

namespace hds {

/// A file to be tried before those that the system's loader finds by name. Thread-safe.
void AddDenoiserLibrary(const std::string& file);

/// \throws Error when a Denoiser could not be made.
void CheckDenoiser();

/// One device of Open Image Denoise. One thread at a time.
class Denoiser {
public:
    /// \throws Error that says where it was looked for.
    Denoiser();
    ~Denoiser();
    Denoiser(const Denoiser&) = delete;
    Denoiser& operator=(const Denoiser&) = delete;

    /// Replaces R, G and B of a linear, premultiplied picture; alpha stays.
    /// \param albedo, normal guides of the same size, three channels; null: none
    /// \throws Error with the library's own words.
    void Apply(const ImageLayer* albedo, const ImageLayer* normal, ImageLayer* color) const;

private:
    struct Library;
    std::unique_ptr<Library> _library;
    void* _device = nullptr;
};

} // namespace hds

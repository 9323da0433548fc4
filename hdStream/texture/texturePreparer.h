// SPDX-License-Identifier: Apache-2.0
// Prepares textures on first request: reads the image, converts colours, filters mips, compresses,
// and keeps the result in the persistent store, where later processes find it.
// Explained in docs/texturing.md.
#pragma once

#include "hdStream/base/log.h"
#include "hdStream/texture/preparedTexture.h"
#include "hdStream/texture/textureForm.h"

#include <memory>
#include <mutex>
#include <optional>
#include <unordered_map>

namespace hds {

/// Makes PreparedTextures. Thread-safe: different textures are prepared at once, one texture once,
/// whoever else wants it waits for it. Nothing throws for the content of a file.
class TexturePreparer {
public:
    /// \param store may be null: prepared lines then stay in host memory
    /// \param warnings takes errors and warnings about files, one line each; may be null
    explicit TexturePreparer(std::shared_ptr<PageStore> store, Warnings* warnings = nullptr);

    /// The texture, from the store or from the file. Blocks until it is there; may be called inside
    /// a task. A file that cannot be used gives a texture with an error, flags MISSING and one
    /// black opaque texel. Never null.
    std::shared_ptr<const PreparedTexture> Prepare(const ImageSource& source,
                                                   const TextureRequest& request);

    /// The record that Prepare would give, as far as the file's header tells: whether the texture
    /// is constant is not known, and float colours are taken for halves. For totals.
    /// \return empty when the file cannot be used.
    static std::optional<shared::HdsTexture> Estimate(const ImageSource& source,
                                                      const TextureRequest& request);

    /// Textures that were read and compressed, not found in the store.
    std::uint64_t NumBuilt() const { return _numBuilt.load(std::memory_order_relaxed); }

private:
    struct Slot {
        std::mutex mutex; ///< held while the texture is prepared
        std::weak_ptr<const PreparedTexture> texture;
    };

    void Report(const TextureDescription& description) const;

    std::shared_ptr<PageStore> _store;
    Warnings* _warnings;
    std::atomic<std::uint64_t> _numBuilt{0};
    std::mutex _mutex;
    std::unordered_map<PageKey, std::shared_ptr<Slot>> _slots;
};

} // namespace hds

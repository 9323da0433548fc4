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

class KeptImages;

/// Makes PreparedTextures. Thread-safe: different textures are prepared at once, one texture once,
/// whoever else wants it waits for it. Nothing throws for the content of a file.
class TexturePreparer {
public:
    /// \param store may be null: prepared lines then stay in host memory
    /// \param warnings takes errors and warnings about files, one line each; may be null
    /// \param keptBytes of codes of files, of which lines are made that are asked for later
    explicit TexturePreparer(std::shared_ptr<PageStore> store, Warnings* warnings = nullptr,
                             std::uint64_t keptBytes = kKeptBytes);

    static constexpr std::uint64_t kKeptBytes = std::uint64_t{512} << 20;
    /// Texels of the finest mip that Prepare makes. Lines of finer ones are made when they are
    /// read: of the codes that are kept, or else of the file, and then all of the mip.
    static constexpr std::uint64_t kTexelsAtOnce = std::uint64_t{1} << 21;
    static constexpr std::uint64_t kAllTexels = ~std::uint64_t{0};

    /// The texture, from the store or from the file. Blocks until it is there; may be called inside
    /// a task. A file that cannot be used gives a texture with an error, flags MISSING and one
    /// black opaque texel. Never null.
    std::shared_ptr<const PreparedTexture> Prepare(const ImageSource& source,
                                                   const TextureRequest& request,
                                                   std::uint64_t texelsAtOnce = kTexelsAtOnce);

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
    std::uint64_t _keptBytes;
    std::shared_ptr<KeptImages> _kept;
    std::atomic<std::uint64_t> _numBuilt{0};
    std::mutex _mutex;
    std::unordered_map<PageKey, std::shared_ptr<Slot>> _slots;
};

} // namespace hds

// SPDX-License-Identifier: Apache-2.0
// Images that materials and lights name: read once each, problems warned about once. Kept from
// commit to commit.
#pragma once

#include "hdStream/base/log.h"
#include "hdStream/shading/lightTable.h"
#include "hdStream/shading/materialCompiler.h"
#include "hdStream/texture/texturePreparer.h"

#include <map>
#include <mutex>

namespace hds {

/// An image that a material or light names.
struct TextureUse {
    std::string authoredPath;
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::uint32_t channels = 0;
    std::uint64_t bytesSource = 0; ///< decoded base level, as read
    std::string channelType;       ///< of its widest channel, as ImageInfo has it
    std::string error;             ///< empty: it can be read
};

ImageSource SourceOf(const AssetReference& asset);
TextureRequest RequestOf(const MaterialTexture& texture);

/// The texture of an image that a light names.
MaterialTexture LightTextureOf(const AssetReference& asset);

/// Equal for equal images read in the same way, whatever channels are read.
std::string MaterialTextureKey(const MaterialTexture& texture);

/// What materials and lights know of images, by file. Thread-safe.
class ImageLibrary {
public:
    explicit ImageLibrary(Warnings& warnings) : _warnings(warnings) {}

    /// Where headers are kept from process to process; null: nowhere. Before the first question.
    void SetPageStore(std::shared_ptr<PageStore> store) { _store = std::move(store); }

    /// What materials need to know of an image; empty when it cannot be read (the caller warns).
    /// Reads its header.
    std::optional<ImageFacts> Probe(const AssetReference& asset);

    /// The files of a UDIM pattern, by index.
    static std::vector<UdimTile> FindTiles(const AssetReference& pattern);

    /// Warns of an image whose texels are not what its header promised; one line that names it.
    void Report(const std::string& problem) { _warnings.Add("", problem); }

    /// One channel of an image in linear light; null when it cannot be read (the caller warns).
    std::shared_ptr<const HeightImage> LoadHeights(const MaterialTexture& texture,
                                                   std::uint32_t channel);
    /// Those of all look-ups of a network.
    void LoadHeights(DisplacementNetwork* network);

    /// What the distribution of a light's image is made of; null when it cannot be read (the caller
    /// warns). Prepares the image as a texture, which stays prepared as long as it is in use.
    std::shared_ptr<const LightImage> LoadLightImage(const AssetReference& asset,
                                                     TexturePreparer* preparer);
    /// Forgets the images of lights that were not asked for since this was called last.
    void DropLightImages();

    /// Starts a new list of uses.
    void BeginCommit();

    /// All images asked for since BeginCommit, each once, in the order of their files.
    std::vector<TextureUse> Uses() const;

    /// What was asked for since BeginCommit of one of them; empty: nothing.
    std::optional<TextureUse> FindUse(const AssetReference& asset) const;

    /// Forgets all images: the next question reads the file again.
    void Clear();
    /// Counts how often that was done: images of another epoch may have changed.
    std::uint64_t Epoch() const;

private:
    struct Header {
        std::optional<ImageFacts> facts;
        TextureUse use;
    };
    struct OfLight {
        std::shared_ptr<const PreparedTexture> texture;
        std::shared_ptr<const LightImage> image;
        TextureUse use;
        bool isAskedFor = false;
    };

    Header ReadHeader(const AssetReference& asset) const;
    OfLight ReadLightImage(const AssetReference& asset, TexturePreparer* preparer) const;

    Warnings& _warnings;
    std::shared_ptr<PageStore> _store;
    mutable std::mutex _mutex;
    std::map<std::string, TextureUse> _uses;  ///< by file and range
    std::map<std::string, Header> _headers;   ///< by file and range
    std::map<std::string, OfLight> _ofLights; ///< by file, range and colour space
    /// By texture and channel, as long as some prim uses it.
    std::map<std::string, std::weak_ptr<const HeightImage>> _heights;
    std::uint64_t _epoch = 0;
};

} // namespace hds

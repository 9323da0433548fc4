// SPDX-License-Identifier: Apache-2.0
// Geometry as it is cut into chunks, and its summary: what is known of it without its triangles.
// The persistent store keeps the summary, so that a second run looks at no geometry whose pages it
// has. Explained in docs/accel.md.
#pragma once

#include "hdStream/accel/chunkPlan.h"
#include "hdStream/accel/pageMaker.h"
#include "hdStream/accel/sourceKeeper.h"
#include "hdStream/persist/pageStore.h"

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

namespace hds {

/// What is known of geometry before a triangle of it is made.
struct GeometrySummary {
    glm::dvec3 origin{0.0}; ///< object-space point that all positions are relative to
    bool isLeftHanded = false;
    std::uint64_t numTriangles = 0; ///< upper bound; exact for polygons
    std::vector<AttributeFormat> attributes;
    TriangleBytes boundBytes;              ///< as ChunkSource::BoundBytes
    std::vector<Bounds> chunkBounds;       ///< [numChunks]
    std::vector<std::uint32_t> numInChunk; ///< [numChunks] triangles, upper bounds

    std::size_t NumChunks() const { return chunkBounds.size(); }
};

/// The summary as bytes of a page, and back; nothing when they are none.
std::vector<std::uint8_t> SerializeSummary(const GeometrySummary& summary);
std::optional<GeometrySummary> ParseSummary(const std::vector<std::uint8_t>& bytes);

/// Immutable, thread-safe.
class ChunkedGeometry final : public PageMaker {
public:
    /// Makes the source: the same however often, perhaps never; any thread, one at a time.
    using SourceMaker = std::function<std::shared_ptr<const ChunkSource>()>;

    /// The source and how it is cut.
    struct Cut {
        std::shared_ptr<const ChunkSource> source;
        ChunkPlan plan;
    };

    /// Takes the summary from the store, or else makes source and plan. \param chunkBytes about
    /// what the pages of a chunk take at most. \param store of summaries and finished pages; may be
    /// null. \param key of all that the source and the plan are made of. \param keeper of sources;
    /// null: it stays once it is made. \param arrayBytes of arrays that the source alone holds.
    ChunkedGeometry(SourceMaker makeSource, std::uint64_t chunkBytes,
                    std::shared_ptr<PageStore> store, const PageKey& key,
                    std::shared_ptr<SourceKeeper> keeper = nullptr, std::uint64_t arrayBytes = 0);
    ~ChunkedGeometry() override;
    ChunkedGeometry(const ChunkedGeometry&) = delete;
    ChunkedGeometry& operator=(const ChunkedGeometry&) = delete;

    const GeometrySummary& Summary() const { return _summary; }
    /// Made where they are not there. Runs no other TBB task meanwhile. \throws what the maker of
    /// the source does.
    std::shared_ptr<const Cut> Hold() const;

    std::array<std::uint64_t, 2> BoundBytes(std::uint32_t chunk) const override;
    ChunkBytes Make(std::uint32_t chunk) const override;
    /// Where the source was made again: the more often it is made the more chunks, so that it is
    /// not made very often (docs/accel.md).
    void MakeAhead(const std::function<bool()>& isCancelled) const override;
    void BeginMaking() const override;
    void EndMaking() const override;
    PageStore* Store() const override { return _store.get(); }
    std::optional<PageKey> Key(std::uint32_t chunk, std::uint32_t page) const override {
        return PartKey(2 * std::uint64_t{chunk} + page);
    }
    /// The name in the store of part `index` of the geometry: its pages in turn.
    PageKey PartKey(std::uint64_t index) const;
    /// Keeps the summary, so that the source need not be made again. Not to be called for geometry
    /// that has warnings: they would not be heard next time.
    void SaveSummary() const;

private:
    bool LoadSummary();
    void MakeSummary(const Cut& cut);
    std::shared_ptr<const Cut> MakeCut() const;
    std::shared_ptr<const Cut> Hold(bool* isMade) const;
    ChunkBytes MakePages(const Cut& cut, std::uint32_t chunk) const;
    void CountMade(std::uint32_t chunk) const;
    bool KeepAhead(const Cut& cut, std::uint32_t chunk) const;
    bool IsStored(std::uint32_t chunk) const;
    std::uint64_t BytesOf(const Cut& cut) const;

    SourceMaker _makeSource;
    std::uint64_t _chunkBytes;
    std::shared_ptr<PageStore> _store;
    PageKey _key;
    GeometrySummary _summary;
    std::shared_ptr<SourceKeeper> _keeper;
    std::uint64_t _arrayBytes;
    mutable std::mutex _mutex;
    mutable std::weak_ptr<const Cut> _cut;
    mutable std::shared_ptr<const Cut> _kept; ///< where there is no keeper, or chunks are made
    mutable std::uint32_t _numMaking = 0;     ///< who makes chunks now (BeginMaking)
    mutable std::uint32_t _numMade = 0;       ///< times that the source was made for pages
    mutable bool _isMadeAgain = false;        ///< since MakeAhead was called
    mutable std::uint32_t _numAhead = 0;      ///< chunks that MakeAhead has taken on
    mutable std::uint32_t _firstAhead = 0;    ///< of these, which follow each other
};

} // namespace hds

// SPDX-License-Identifier: Apache-2.0
// Streaming mode of textures: a pool of fixed size holds those lines
// that kernels have asked for; others leave when room is needed. Explained in docs/texturing.md.
#pragma once

#include "hdStream/device/program.h"
#include "hdStream/texture/lineBuffers.h"
#include "hdStream/texture/lineProvider.h"
#include "hdStream/texture/lineSlots.h"
#include "hdStream/texture/lineTable.h"
#include "hdStream/texture/openTextures.h"
#include "hdStream/texture/textureStatistics.h"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

namespace hds {

/// What grids of volumes may take of a pool, and need.
struct GridBudget {
    std::uint64_t bytes = 0;        ///< 0: they share what there is with the other textures
    std::uint32_t linesPerItem = 0; ///< most lines of theirs that an item needs at once
};

/// Device memory that holds some lines of a provider's textures. Externally synchronised.
///
/// Launch; then, as long as items wait for texels, ProcessRequests and launch again over those that
/// wait. Kernels mark what they use; a round takes nothing away that was used since the one before.
/// It ends because lines stay as long as items that wait use them. When a round could not load all
/// that was asked for, and no item was done since the one before, the pool is too small for so many
/// items at once: launch fewer. One item alone always finds room.
class TexturePool {
public:
    /// What a round has done.
    struct Outcome {
        std::uint32_t numLoaded = 0; ///< lines, and textures that were opened
        std::uint32_t numDenied = 0; ///< requests that found no room
        bool isCancelled = false;    ///< what was not loaded is forgotten
    };

    static constexpr std::uint32_t kRequestCapacity = 1U << 16U;
    static constexpr std::uint32_t kAnyItems = ~0U;

    /// An empty pool. \param store keeps compiled kernels, may be null. \param requestCapacity most
    /// requests answered at a time; more come again.
    explicit TexturePool(std::shared_ptr<Device> device, Store* store = nullptr,
                         std::uint32_t requestCapacity = kRequestCapacity);

    /// What its kernels are compiled from; the same for all scenes.
    static ProgramSource KernelSource(const Device& device);

    /// Serves the textures of `provider`, which must live until the next call, from at most
    /// `budgetBytes` of device memory, and its grids from these or from a budget of their own. What
    /// is loaded stays, as far as textures are the same (by id) and budgets are.
    /// \param linesPerItem most lines that an item needs at once, without those of grids.
    /// \throws Error that names the option --textureMemory or --volumeMemory when these do not fit.
    void Update(LineProvider* provider, std::uint64_t budgetBytes, std::uint32_t linesPerItem,
                GridBudget grids = {});

    /// Counts from 0 again.
    void BeginStatistics();
    /// Makes room for so many items that wait. \pre none waits.
    void ReserveItems(std::uint32_t numItems);
    /// The items that wait since the last call, in order.
    std::vector<std::uint32_t> TakeWaiting();

    /// Whether the launches to come take coarser mips for lines that are missing: only items of
    /// whose texture nothing is loaded yet wait.
    void SetAcceptsCoarserMips(bool accepts);
    /// Opens textures and loads lines that were asked for. Blocks. \param numItems most items of
    /// the launches up to the next call, or to ExpectAnyItems: what few can ask for is soon
    /// cleared. \param isCancelled asked between images and batches of lines; where it says so, the
    /// others are not loaded, and those who wait for them must be given up.
    Outcome ProcessRequests(std::uint32_t numItems = kAnyItems,
                            const LineProvider::IsCancelled& isCancelled = {});
    /// Launches to come may be of any number of items.
    void ExpectAnyItems() { SetSetSize(_maxSetSize); }
    /// Adds what kernels have counted to the statistics. Blocks.
    void CollectCounts();

    /// Bind again when Generation has changed: buffers have grown.
    TextureBinding Binding() const;
    std::uint64_t Generation() const { return _generation; }
    std::uint32_t NumBuffers() const { return _buffers ? _buffers->NumBuffers() : 0; }
    /// Bytes of device memory for lines, and for what streaming needs besides.
    std::uint64_t Bytes() const { return _buffers ? _buffers->Bytes() : 0; }
    /// The most bytes of lines that were in the pool at a time since BeginStatistics.
    std::uint64_t PeakUsedBytes() const;
    /// Of these, the most that lines of grids with a budget of their own were.
    std::uint64_t GridPeakUsedBytes() const;
    std::uint64_t TableBytes() const;
    std::uint64_t PinnedBytes() const;
    const TextureStatistics& Statistics() const { return _statistics; }

private:
    /// A line that is to be loaded.
    struct Load {
        std::uint32_t line = 0;
        bool isPinned = false;
    };

    /// How many slots there are.
    struct PoolPlan {
        SlotPlan lines; ///< of all, but for grids that have a part of their own
        SlotPlan grids;
        bool keepsStamps = true; ///< false: there is room for all lines, so none ever leaves

        static constexpr auto Fields() {
            return FieldList(HDS_FIELD(PoolPlan, lines), HDS_FIELD(PoolPlan, grids),
                             HDS_FIELD(PoolPlan, keepsStamps));
        }
    };
    /// What is asked of a part of the pool.
    struct Part {
        std::string option;
        std::string lines; ///< what they are, for a message
        std::uint64_t budgetBytes;
        std::uint32_t numTextures;
        std::uint32_t linesPerItem;
        std::uint64_t maxLines;
    };
    static SlotPlan PlanPart(const Part& part, std::uint64_t maxSlots, bool* keepsStamps);
    PoolPlan Plan(std::uint64_t budgetBytes, std::uint32_t linesPerItem,
                  const GridBudget& grids) const;
    void MakePool(const PoolPlan& plan);
    bool IsOfGrid(const LineId& line) const { return line.texture >= _provider->FirstGrid(); }
    std::uint32_t NumSlots() const;
    void ForEachPart(const std::function<void(const LineSlots&)>& action) const;
    void RemoveLines(const std::vector<LineRange>& ranges);
    void MakeRequests();
    void SetSetSize(std::uint32_t numWords);
    std::uint32_t TakeCounts();
    std::vector<std::uint32_t> TakeRequests();
    bool OpenAll(const std::vector<std::uint32_t>& textures, std::vector<Load>* loads,
                 const LineProvider::IsCancelled& isCancelled);
    void LoadAll(const std::vector<Load>& loads, Outcome* outcome,
                 const LineProvider::IsCancelled& isCancelled);
    void LoadBatch(const std::vector<Load>& loads, Outcome* outcome,
                   const LineProvider::IsCancelled& isCancelled);
    std::uint32_t PlaceLine(const Load& load, bool isOfGrid, const std::uint8_t* bytes,
                            bool* needsCopy);
    void CopyStaged(std::vector<shared::HdsLineCopy> copies);
    void PublishTable();
    void ReadyKernels();
    const std::uint32_t* ReadStamps();
    /// As kernels see it.
    std::uint32_t Epoch() const { return _plan.keepsStamps ? _epoch : 0; }

    std::shared_ptr<Device> _device;
    Store* _store;
    std::unique_ptr<Program> _program; ///< null until its kernels are launched
    Kernel _copyLines;
    Kernel _updateTable;
    std::uint32_t _requestCapacity;
    LineProvider* _provider = nullptr;
    OpenTextures _textures;
    LineTable _table;
    PoolPlan _plan;
    std::unique_ptr<LineSlots> _slots;
    std::unique_ptr<LineSlots> _gridSlots; ///< null: grids have none of their own
    std::unique_ptr<LineBuffers> _buffers;
    /// Slots of lines of one repeated block, pinned; by that block.
    std::unordered_map<std::string, std::uint32_t> _sharedSlots;
    Buffer _records;
    Buffer _lineTable;
    Buffer _requests;
    Buffer _stamps;
    Buffer _waiting;
    Buffer _staging; ///< lines on their way
    Buffer _copies;
    Buffer _updates;
    std::vector<std::uint8_t> _stagedBytes;
    std::optional<BufferView> _stampView; ///< in a round where lines have to leave
    bool _acceptsCoarserMips = false;
    std::uint32_t _setBegin = 0;
    std::uint32_t _maxSetSize = 0;
    std::uint32_t _setSize = 0;      ///< words that kernels use; all beyond are clear
    std::uint32_t _linesPerItem = 0; ///< of all kinds
    std::uint32_t _epoch = 1;        ///< counts rounds of requests
    std::uint64_t _generation = 0;
    TextureStatistics _statistics;
};

} // namespace hds

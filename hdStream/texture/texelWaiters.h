// SPDX-License-Identifier: Apache-2.0
// Work-items that wait for texels, and how many of them are launched at a time. Explained in
// docs/texturing.md.
#pragma once

#include "hdStream/texture/texturePool.h"

#include <cstdint>
#include <vector>

namespace hds {

/// Items that are to be launched again. As long as rounds of requests find room for what is asked
/// for, all go together; when they do not and nothing gets done, fewer and fewer, in the end one
/// alone. That finds room, if not at once: a walk that waits in the middle goes on from there, and
/// then lines that it has used before may go. Externally synchronised.
///
///     TexelWaiters waiters(numLaunched, items that wait);
///     while (!waiters.IsEmpty()) {
///         waiters.Continue(pool.ProcessRequests());
///         batch = waiters.Take(); launch it; waiters.Return(items of it that wait);
///     }
class TexelWaiters {
public:
    TexelWaiters(std::uint32_t numLaunched, std::vector<std::uint32_t> waiting);

    bool IsEmpty() const { return _items.empty(); }
    std::uint32_t NumItems() const { return static_cast<std::uint32_t>(_items.size()); }
    /// Decides how many go next. \throws Error when the pool cannot hold what one item needs.
    void Continue(const TexturePool::Outcome& outcome);
    /// The items to launch.
    std::vector<std::uint32_t> Take();
    /// Those that still wait.
    void Return(const std::vector<std::uint32_t>& waiting);

private:
    std::vector<std::uint32_t> _items;
    std::size_t _numLaunched;
    std::size_t _numWaiting;     ///< of these
    std::size_t _limit;          ///< of the next launch
    bool _isAloneDenied = false; ///< one item alone has just found no room
};

} // namespace hds

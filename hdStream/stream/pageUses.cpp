// SPDX-License-Identifier: Apache-2.0
#include "hdStream/stream/pageUses.h"

#include <algorithm>

namespace hds {

std::vector<PageRequest> PageUses::TakeRequests(const PageTable& table, bool withGroups) {
    std::vector<PageRequest> requests;
    for (std::uint32_t page = 0; page < _words.size(); ++page) {
        const std::uint32_t asked = _words[page];
        if (asked != 0 && !table.HasPlace(page)) {
            requests.push_back(
                {page, asked & ~HDS_ASKED_WHOLE, withGroups && (asked & HDS_ASKED_WHOLE) != 0});
            _words[page] = 0;
        }
    }
    std::sort(requests.begin(), requests.end(), [](const PageRequest& a, const PageRequest& b) {
        return a.count != b.count ? a.count > b.count : a.page < b.page;
    });
    return requests;
}

} // namespace hds

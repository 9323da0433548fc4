// SPDX-License-Identifier: Apache-2.0
#include "hdStream/session/warningDigest.h"

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <map>
#include <sstream>

namespace hds {

namespace {

constexpr std::size_t kNumNames = 3; ///< named of each kind

/// Where the text of "PRIM: TEXT" begins; 0: the line names no prim.
std::size_t TextBegin(const std::string& line) {
    const std::size_t colon = line.find(": ");
    const bool namesPrim =
        line.compare(0, 1, "/") == 0 && colon != std::string::npos && line.find(' ') > colon;
    return namesPrim ? colon + 2 : 0;
}

bool IsNumber(const std::string& word) {
    return std::isdigit(static_cast<unsigned char>(word.front())) != 0 &&
           std::all_of(word.begin(), word.end(), [](unsigned char c) {
               return std::isdigit(c) != 0 || std::ispunct(c) != 0;
           });
}

/// A text without what tells one prim's from another's.
std::string KindOf(const std::string& text) {
    std::istringstream words(text);
    std::string kind;
    for (std::string word; words >> word;) {
        kind += word.front() == '/' ? "/" : IsNumber(word) ? "0" : word;
        kind += ' ';
    }
    return kind;
}

struct Group {
    std::vector<std::string> prims; ///< each once
    std::string text;               ///< of the first
    bool areAlike = false;          ///< texts differ
};

std::string LineOf(const Group& group) {
    const std::size_t count = group.prims.size();
    std::string line = group.prims.front();
    for (std::size_t i = 1; i < std::min(count, kNumNames); ++i) {
        line += (i + 1 == count ? " and " : ", ") + group.prims[i];
    }
    if (count > kNumNames) {
        line += " and " + std::to_string(count - kNumNames) + " more";
    }
    return line + ": " + group.text + (group.areAlike ? " (or alike)" : "");
}

} // namespace

std::vector<std::string> DigestWarnings(std::vector<std::string> lines) {
    std::sort(lines.begin(), lines.end());
    std::map<std::string, std::size_t> indexByKind;
    std::vector<Group> groups; // in the order of their first lines
    for (const std::string& line : lines) {
        const std::size_t begin = TextBegin(line);
        const std::string prim = line.substr(0, begin == 0 ? 0 : begin - 2);
        const std::string text = line.substr(begin);
        const std::string kind = begin == 0 ? line : "/ " + KindOf(text);
        const auto [known, isNew] = indexByKind.insert({kind, groups.size()});
        if (isNew) {
            groups.push_back({{prim}, text, false});
            continue;
        }
        Group& group = groups[known->second];
        if (group.prims.back() != prim) {
            group.prims.push_back(prim);
        }
        group.areAlike |= text != group.text;
    }
    std::vector<std::string> result;
    result.reserve(groups.size());
    for (const Group& group : groups) {
        result.push_back(group.prims.front().empty() ? group.text : LineOf(group));
    }
    return result;
}

} // namespace hds

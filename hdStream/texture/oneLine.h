// SPDX-License-Identifier: Apache-2.0
// Messages of image libraries as one line: our errors are one line each (docs/command-line.md).
#pragma once

#include <string>

namespace hds {

/// The text without trailing line breaks, inner ones replaced by "; ".
inline std::string OneLine(const std::string& text) {
    std::string line;
    for (const char c : text) {
        if (c == '\n' || c == '\r') {
            if (!line.empty() && line.back() != '\n') {
                line += '\n'; // one mark for any run of breaks
            }
        } else {
            line += c;
        }
    }
    while (!line.empty() && (line.back() == '\n' || line.back() == ' ')) {
        line.pop_back();
    }
    for (std::size_t at = line.find('\n'); at != std::string::npos; at = line.find('\n')) {
        line.replace(at, 1, "; ");
    }
    return line;
}

} // namespace hds

// SPDX-License-Identifier: Apache-2.0
// Includes: once by path, #line at each switch of file.
#include "hdStream/device/kernelSource.h"

#include "hdStream/base/error.h"
#include "hdStream/base/hash.h"
#include "hdStream/device/embeddedKernels.h"

#include <cstdlib>
#include <cstring>
#include <fstream>
#include <set>
#include <sstream>

namespace hds {

namespace {

/// Every program is compiled with strict arithmetic: bits are part of the contract.
constexpr const char* kPrologue = "#pragma OPENCL FP_CONTRACT OFF\n";

bool FindEmbedded(const std::string& path, std::string* text) {
    for (std::size_t i = 0; i < NumEmbeddedKernels(); ++i) {
        const EmbeddedKernel& file = EmbeddedKernels()[i];
        if (path == file.path) {
            text->assign(reinterpret_cast<const char*>(file.bytes), file.size);
            return true;
        }
    }
    return false;
}

std::string ReadKernelFile(const std::string& path, const std::string& includer) {
    std::string text;
    if (const char* folder = std::getenv("HDSTREAM_KERNEL_DIR");
        folder != nullptr && *folder != 0) {
        std::ifstream file(std::string(folder) + "/" + path, std::ios::binary);
        if (file) {
            std::ostringstream contents;
            contents << file.rdbuf();
            return contents.str();
        }
    } else if (FindEmbedded(path, &text)) {
        return text;
    }
    throw Error("kernel source " + path + " does not exist (included by " + includer + ")");
}

/// The path of an `#include "path"` line, or empty.
std::string IncludedPath(const std::string& line) {
    std::size_t at = line.find_first_not_of(" \t");
    if (at == std::string::npos || line[at] != '#') {
        return {};
    }
    at = line.find_first_not_of(" \t", at + 1);
    if (at == std::string::npos || line.compare(at, 7, "include") != 0) {
        return {};
    }
    const std::size_t open = line.find('"', at);
    const std::size_t close = open == std::string::npos ? open : line.find('"', open + 1);
    return close == std::string::npos ? std::string() : line.substr(open + 1, close - open - 1);
}

/// The directive of a line ("if", "ifdef", "ifndef", "endif", "define", ...), or empty.
std::string Directive(const std::string& line) {
    std::size_t at = line.find_first_not_of(" \t");
    if (at == std::string::npos || line[at] != '#') {
        return {};
    }
    at = line.find_first_not_of(" \t", at + 1);
    const std::size_t end =
        at == std::string::npos ? at : line.find_first_not_of("abcdefghijklmnopqrstuvwxyz", at);
    return at == std::string::npos ? std::string() : line.substr(at, end - at);
}

/// How many conditionals are open at each line, not counting a header's own include guard, which is
/// the first directive of the file: #ifndef, or #if !defined of text that has a wide form.
class ConditionalDepth {
public:
    void Read(const std::string& line) {
        const std::string directive = Directive(line);
        if (directive.empty()) {
            return;
        }
        if (directive.compare(0, 2, "if") == 0) {
            const bool isGuard = _isFirst && (directive == "ifndef" ||
                                              line.find("if !defined(") != std::string::npos);
            _depth += isGuard ? 0 : 1;
        } else if (directive == "endif") {
            --_depth; // the guard's own #endif is the last line: -1 there means nothing
        }
        _isFirst = false;
    }
    bool IsConditional() const { return _depth > 0; }

private:
    int _depth = 0;
    bool _isFirst = true;
};

using FileSet = std::set<std::string>;

/// A block of includes for the wide form of what they hold (kernels/math/wideBegin.clh). It names
/// all its files: they come again, without what they include.
constexpr const char* kWideBegin = "math/wideBegin.clh";
constexpr const char* kWideEnd = "math/wideEnd.clh";

/// X-macro lists (.def) are meant to be included many times.
bool IsList(const std::string& path) {
    return path.size() > 4 && path.compare(path.size() - 4, 4, ".def") == 0;
}

/// Appends files with their includes. A file comes once; one that was included inside a conditional
/// may come again outside of it, where its guard decides.
class Expander {
public:
    explicit Expander(std::string* out) : _out(out) {}

    void Expand(const std::string& path, const std::string& text, FileSet* seen) {
        *_out += "#line 1 \"" + path + "\"\n";
        std::istringstream lines(text);
        std::string line;
        int number = 0;
        ConditionalDepth depth;
        while (std::getline(lines, line)) {
            ++number;
            depth.Read(line);
            const std::string included = IncludedPath(line);
            if (included.empty()) {
                *_out += line;
                *_out += '\n';
                continue;
            }
            Include(included, path, depth.IsConditional(), seen);
            *_out += "#line " + std::to_string(number + 1) + " \"" + path + "\"\n";
        }
    }

private:
    void Include(const std::string& included, const std::string& path, bool isConditional,
                 FileSet* seen) {
        if (included == kWideBegin) {
            _wideBlockOf = path;
        }
        const bool isInBlock = _wideBlockOf == path;
        const bool isWanted = _wideBlockOf.empty() ? seen->count(included) == 0 : isInBlock;
        if (IsList(included) || isWanted) {
            FileSet inside = *seen;
            FileSet* target = isConditional || isInBlock ? &inside : seen;
            if (!IsList(included)) {
                target->insert(included);
            }
            Expand(included, ReadKernelFile(included, path), target);
        }
        if (included == kWideEnd) {
            _wideBlockOf.clear();
        }
    }

    std::string* _out;
    std::string _wideBlockOf; ///< the file whose wide block is being read; empty: none is
};

} // namespace

std::string ExpandKernelSource(const std::string& root, const std::string* text) {
    std::string source = kPrologue;
    FileSet seen;
    Expander(&source).Expand(root, text != nullptr ? *text : ReadKernelFile(root, "the program"),
                             &seen);
    return source;
}

std::string KernelSourceHash() {
    Hasher hasher;
    for (std::size_t i = 0; i < NumEmbeddedKernels(); ++i) {
        const std::string path = EmbeddedKernels()[i].path;
        hasher.Append(std::string_view(path));
        hasher.Append(std::string_view(ReadKernelFile(path, "the hash of all kernels")));
    }
    return hasher.Hex();
}

} // namespace hds

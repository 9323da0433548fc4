// SPDX-License-Identifier: Apache-2.0
// Includes: once by path, #line at each switch of file.
#include "hdStream/device/kernelSource.h"

#include "hdStream/base/error.h"
#include "hdStream/base/hash.h"
#include "hdStream/device/embeddedKernels.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <string_view>

namespace hds {

namespace {

/// Every program is compiled with strict arithmetic: bits are part of the contract.
constexpr const char* kPrologue = "#pragma OPENCL FP_CONTRACT OFF\n";

/// The text of an embedded file, or null data.
std::string_view FindEmbedded(const std::string& path) {
    for (std::size_t i = 0; i < NumEmbeddedKernels(); ++i) {
        const EmbeddedKernel& file = EmbeddedKernels()[i];
        if (path == file.path) {
            return {reinterpret_cast<const char*>(file.bytes), file.size};
        }
    }
    return {};
}

const char* KernelFolder() {
    const char* folder = std::getenv("HDSTREAM_KERNEL_DIR");
    return folder != nullptr && *folder != 0 ? folder : nullptr;
}

/// \param read holds the text of files that are not embedded.
std::string_view ReadKernelFile(const std::string& path, const std::string& includer,
                                std::string* read) {
    if (const char* folder = KernelFolder(); folder != nullptr) {
        std::ifstream file(std::string(folder) + "/" + path, std::ios::binary);
        if (file) {
            read->assign(std::istreambuf_iterator<char>(file), {});
            return *read;
        }
    } else if (const std::string_view text = FindEmbedded(path); text.data() != nullptr) {
        return text;
    }
    throw Error("kernel source " + path + " does not exist (included by " + includer + ")");
}

/// A line that begins with '#', from the word after it on; empty: another line.
std::string_view Directive(std::string_view line) {
    constexpr const char* kBlanks = " \t";
    std::size_t at = line.find_first_not_of(kBlanks);
    if (at == std::string_view::npos || line[at] != '#') {
        return {};
    }
    at = line.find_first_not_of(kBlanks, at + 1);
    return at == std::string_view::npos ? std::string_view() : line.substr(at);
}

bool BeginsWith(std::string_view text, std::string_view beginning) {
    return text.substr(0, beginning.size()) == beginning;
}

/// The path of an `#include "path"` line, or empty.
std::string IncludedPath(std::string_view directive) {
    if (!BeginsWith(directive, "include")) {
        return {};
    }
    const std::size_t open = directive.find('"');
    const std::size_t close = open == std::string_view::npos ? open : directive.find('"', open + 1);
    return close == std::string_view::npos
               ? std::string()
               : std::string(directive.substr(open + 1, close - open - 1));
}

/// How many conditionals are open at each line, not counting a header's own include guard, which is
/// the first directive of the file: #ifndef, or #if !defined of text that has a wide form.
class ConditionalDepth {
public:
    void Read(std::string_view directive) {
        if (BeginsWith(directive, "if")) {
            const bool isGuard = _isFirst && (BeginsWith(directive, "ifndef") ||
                                              BeginsWith(directive, "if !defined("));
            _depth += isGuard ? 0 : 1;
        } else if (BeginsWith(directive, "endif")) {
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

    void Expand(const std::string& path, std::string_view text, FileSet* seen) {
        BeginFile(1, path);
        ConditionalDepth depth;
        std::size_t copied = 0; ///< up to there, whole lines
        int number = 0;
        for (std::size_t begin = 0; begin < text.size();) {
            ++number;
            const std::size_t end = std::min(text.find('\n', begin), text.size());
            const std::string_view directive = Directive(text.substr(begin, end - begin));
            if (!directive.empty()) {
                depth.Read(directive);
                if (const std::string included = IncludedPath(directive); !included.empty()) {
                    _out->append(text.substr(copied, begin - copied));
                    copied = std::min(end + 1, text.size());
                    Include(included, path, depth.IsConditional(), seen);
                    BeginFile(number + 1, path);
                }
            }
            begin = end + 1;
        }
        _out->append(text.substr(copied));
        if (_out->back() != '\n') {
            *_out += '\n';
        }
    }

private:
    void BeginFile(int line, const std::string& path) {
        _out->append("#line ").append(std::to_string(line)).append(" \"").append(path);
        *_out += "\"\n";
    }

    void Include(const std::string& included, const std::string& path, bool isConditional,
                 FileSet* seen) {
        if (included == kWideBegin) {
            _wideBlockOf = path;
        }
        const bool isInBlock = _wideBlockOf == path;
        const bool isWanted = _wideBlockOf.empty() ? seen->count(included) == 0 : isInBlock;
        if (IsList(included) || isWanted) {
            FileSet inside;
            FileSet* target = seen;
            if (isConditional || isInBlock) {
                inside = *seen;
                target = &inside;
            }
            if (!IsList(included)) {
                target->insert(included);
            }
            std::string read;
            Expand(included, ReadKernelFile(included, path, &read), target);
        }
        if (included == kWideEnd) {
            _wideBlockOf.clear();
        }
    }

    std::string* _out;
    std::string _wideBlockOf; ///< the file whose wide block is being read; empty: none is
};

/// Our file and line ("math/trig.clh:12") of a line of the whole text, which is counted from 1.
std::string KernelLine(std::string_view text, std::size_t number) {
    std::string_view file = "<kernel>";
    std::size_t line = 0;
    for (std::size_t at = 0, begin = 0; at < number && begin < text.size(); ++at) {
        const std::size_t end = std::min(text.find('\n', begin), text.size());
        const std::string_view directive = Directive(text.substr(begin, end - begin));
        const std::size_t open = directive.find('"');
        if (BeginsWith(directive, "line ") && open != std::string_view::npos) {
            file = directive.substr(open + 1, directive.size() - open - 2);
            line = std::stoul(std::string(directive.substr(5))) - 1; // of the line before
        } else {
            ++line;
        }
        begin = end + 1;
    }
    return std::string(file) + ":" + std::to_string(line);
}

} // namespace

std::string ExpandKernelSource(const std::string& root, const std::string* text) {
    std::string source = kPrologue;
    std::string read;
    FileSet seen;
    Expander(&source).Expand(
        root, text != nullptr ? *text : ReadKernelFile(root, "the program", &read), &seen);
    return source;
}

std::string NameKernelLines(const std::string& log, const std::string& text) {
    static const std::regex kLineOfAll("<kernel>:([0-9]{1,9})");
    std::string named;
    auto copied = log.cbegin();
    for (std::sregex_iterator found(log.begin(), log.end(), kLineOfAll), end; found != end;
         ++found) {
        named.append(copied, (*found)[0].first);
        named += KernelLine(text, std::stoul((*found)[1]));
        copied = (*found)[0].second;
    }
    return named.append(copied, log.cend());
}

bool AreKernelsEmbedded() {
    return KernelFolder() == nullptr;
}

std::string KernelSourceHash() {
    Hasher hasher;
    std::string read;
    for (std::size_t i = 0; i < NumEmbeddedKernels(); ++i) {
        const std::string path = EmbeddedKernels()[i].path;
        hasher.Append(std::string_view(path));
        hasher.Append(ReadKernelFile(path, "the hash of all kernels", &read));
    }
    return hasher.Hex();
}

} // namespace hds

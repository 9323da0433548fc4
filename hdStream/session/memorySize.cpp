// SPDX-License-Identifier: Apache-2.0
#include "hdStream/session/memorySize.h"

#include "hdStream/base/error.h"

#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>

namespace hds {

namespace {

constexpr double kMaxPercent = 100.0;
constexpr double kMaxBytes = 1e18;

[[noreturn]] void Fail(const std::string& text, const char* expected) {
    throw Error("'" + text + "' is not " + expected, ErrorKind::Usage);
}

/// The number that is all of the text, whatever the locale; NaN when it is none.
double NumberOf(const std::string& text) {
    double number = 0.0;
    const char* end = text.data() + text.size();
    const std::from_chars_result result = std::from_chars(text.data(), end, number);
    const bool isNumber = result.ec == std::errc() && result.ptr == end;
    return isNumber ? number : std::numeric_limits<double>::quiet_NaN();
}

/// The power of 1024 that a suffix stands for; -1: it is none.
int PowerOf(char suffix) {
    const std::size_t place = std::string("KMGT").find(
        static_cast<char>(std::toupper(static_cast<unsigned char>(suffix))));
    return place == std::string::npos ? -1 : static_cast<int>(place) + 1;
}

/// \param forms what the message says that would be right.
std::uint64_t BytesOf(const std::string& text, const char* forms) {
    const int power = text.empty() ? -1 : PowerOf(text.back());
    const double number = NumberOf(power > 0 ? text.substr(0, text.size() - 1) : text);
    const double bytes = power > 0 ? std::ldexp(number, 10 * power) : number;
    if (!(bytes < kMaxBytes)) {
        Fail(text, forms);
    }
    if (!(bytes >= 1.0)) {
        Fail(text, "a size above 0");
    }
    return static_cast<std::uint64_t>(bytes);
}

} // namespace

std::uint64_t ParseBytes(const std::string& text) {
    return BytesOf(text, "a size such as 512M or 2G");
}

MemorySize ParseMemorySize(const std::string& text) {
    MemorySize size;
    if (text.empty() || text.back() != '%') {
        size.bytes = BytesOf(text, "a size such as 512M, 2G or 30%");
        return size;
    }
    const double percent = NumberOf(text.substr(0, text.size() - 1));
    if (!(percent > 0.0 && percent <= kMaxPercent)) {
        Fail(text, "a percentage in 0..100");
    }
    size.share = percent / kMaxPercent;
    return size;
}

} // namespace hds

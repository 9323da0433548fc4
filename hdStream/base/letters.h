// SPDX-License-Identifier: Apache-2.0
// Letters of extensions and names, whatever the locale: Python takes that of the user, and a
// Turkish one has no lower case for the I of TIF.
#pragma once

namespace hds {

/// Of A to Z the one of a to z; all else as it is.
constexpr char LowerLetter(char letter) {
    return letter >= 'A' && letter <= 'Z' ? static_cast<char>(letter - 'A' + 'a') : letter;
}

} // namespace hds

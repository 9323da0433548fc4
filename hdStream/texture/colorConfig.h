// SPDX-License-Identifier: Apache-2.0
// The OpenColorIO configuration in force: the one $OCIO names, else a small one made in memory.
// The renderer's working space is the configuration's scene_linear role (linear Rec.709 in ours).
// Included by texture (decoding) and film (display); pulls OpenColorIO's header in.
#pragma once

#include <OpenColorIO/OpenColorIO.h>

#include <string>

namespace hds {

/// The configuration; read again when $OCIO has changed since the last call. Thread-safe as long
/// as no thread changes the environment meanwhile.
/// \throws Error that names the file when $OCIO cannot be read
OCIO_NAMESPACE::ConstConfigRcPtr ColorConfig();

/// A text that changes when the configuration in force, or a file that it uses, does. Thread-safe.
/// \throws as ColorConfig
std::string ColorConfigIdentity();

/// Whether $OCIO names a configuration.
bool HasUserColorConfig();

} // namespace hds

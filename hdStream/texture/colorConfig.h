// SPDX-License-Identifier: Apache-2.0
// The OpenColorIO configuration in force: the one $OCIO names, else a small one made in memory.
// The renderer's working space is the one that the setting workingSpace names, else the
// configuration's scene_linear role (linear Rec.709 in ours).
// Included by texture (decoding) and film (display); pulls OpenColorIO's header in.
#pragma once

#include <OpenColorIO/OpenColorIO.h>

#include <array>
#include <optional>
#include <string>

namespace hds {

/// The configuration; read again when $OCIO has changed since the last call, or
/// RefreshColorConfig has found other files. Thread-safe as long
/// as no thread changes the environment meanwhile.
/// \throws Error that names the file when $OCIO cannot be read
OCIO_NAMESPACE::ConstConfigRcPtr ColorConfig();

/// Whether $OCIO names a configuration.
bool HasUserColorConfig();

/// The configuration made in memory, whatever $OCIO is. Thread-safe.
OCIO_NAMESPACE::ConstConfigRcPtr BuiltInColorConfig();

/// From one space to another, by their names in the configuration in force. Names that only the
/// built-in configuration has are found there, where both configurations have interchange roles. A
/// space that a stage defines (UsdColorSpaceDefinitionAPI) is "primaries:" and ten numbers with
/// blanks between them: CIE xy of red, green, blue and white, the gamma and the linear bias.
/// \throws std::exception when a name is unknown or there is no way between the two
OCIO_NAMESPACE::ConstCPUProcessorRcPtr MakeColorProcessor(const std::string& from,
                                                          const std::string& to);

/// CIE xy of red, green, blue and white of a linear space of the built-in configuration; nothing:
/// it is another one.
std::optional<std::array<float, 8>> ChromaticitiesOf(const std::string& space);

} // namespace hds

// SPDX-License-Identifier: Apache-2.0
// What an OpenColorIO configuration is made of: its own file, those of its tables (LUTs), and the
// values of variables that it names.
#pragma once

#include "hdStream/texture/colorConversion.h"

#include <OpenColorIO/OpenColorIO.h>

#include <string>

namespace hds {

/// \param name of the configuration's file; another name counts as a word
ColorConfigSources SourcesOf(const OCIO_NAMESPACE::ConstConfigRcPtr& config,
                             const std::string& name);

/// A text that changes when the words do or, as far as AppendFileIdentity sees it, a file.
std::string IdentityOf(const ColorConfigSources& sources);

} // namespace hds

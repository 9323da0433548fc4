// SPDX-License-Identifier: Apache-2.0
// Settings as users give them -> checked options of the integrator.
#pragma once

#include "hdStream/integrator/renderOptions.h"
#include "hdStream/scene/commit.h"
#include "hdStream/session/settings.h"
#include "hdStream/texture/colorConversion.h" // ColorConfigSources, which front ends ask for

#include <string>

namespace hds {

/// Largest width and height of an image.
constexpr std::uint32_t kMaxImageSize = 32768;

/// Whether a name is one of a colour space that can be rendered in.
/// \throws Error when $OCIO cannot be read
bool IsWorkingSpace(const std::string& name);

/// \throws Error (usage) that names the option of the first setting that is out of range.
void CheckSettings(const Settings& settings);

/// Precondition: CheckSettings passed.
RenderOptions MakeRenderOptions(const Settings& settings, const CameraPrim& camera);

/// Precondition: CheckSettings passed.
ResidencyOptions MakeResidencyOptions(const Settings& settings);

/// Precondition: CheckSettings passed.
CommitOptions MakeCommitOptions(const Settings& settings);

} // namespace hds

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pxr/imaging/hd/command.h>
#include <pxr/pxr.h>

PXR_NAMESPACE_OPEN_SCOPE

class HdStreamRenderParam;

/// The commands of the delegate: flushTextures, clearCache, dumpScene.
HdCommandDescriptors HdStreamCommandDescriptors();

/// Runs a command. Returns false when there is none of that name, an argument is wrong, or it
/// failed, which is reported as an error.
/// \param cacheDirectory the setting of that name
bool HdStreamInvokeCommand(HdStreamRenderParam* param, const std::string& cacheDirectory,
                           const TfToken& command, const HdCommandArgs& arguments);

PXR_NAMESPACE_CLOSE_SCOPE

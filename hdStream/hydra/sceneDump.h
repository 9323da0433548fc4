// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pxr/pxr.h>

#include <string>

PXR_NAMESPACE_OPEN_SCOPE

class HdStreamRenderParam;

/// The file named by the environment variable HDSTREAM_DUMP_SCENE, read once; empty: none.
const std::string& HdStreamDumpFile();

/// Has the render thread write the scene as text to a file, after the edits so far. Does not wait;
/// a file that cannot be written is a warning.
void HdStreamPostDump(HdStreamRenderParam* param, const std::string& file);

PXR_NAMESPACE_CLOSE_SCOPE

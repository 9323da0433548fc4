// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/commands.h"

#include "hdStream/hydra/renderParam.h"
#include "hdStream/hydra/sceneDump.h"

#include <pxr/base/tf/diagnostic.h>
#include <pxr/base/tf/staticTokens.h>

#include <exception>

PXR_NAMESPACE_OPEN_SCOPE

// clang-format off
TF_DEFINE_PRIVATE_TOKENS(_tokens,
    (flushTextures)
    (redice)
    (clearCache)
    (dumpScene)
    (file)
);
// clang-format on

HdCommandDescriptors HdStreamCommandDescriptors() {
    return {
        HdCommandDescriptor(_tokens->flushTextures,
                            "Forgets what was read from image files and reads them again"),
        HdCommandDescriptor(_tokens->redice, "Dices subdivision surfaces for the present camera"),
        HdCommandDescriptor(_tokens->clearCache, "Deletes the files of the persistent cache"),
        HdCommandDescriptor(_tokens->dumpScene, "Writes the scene as text to a file",
                            {HdCommandArgDescriptor(_tokens->file, VtValue(std::string()))}),
    };
}

bool HdStreamInvokeCommand(HdStreamRenderParam* param, const std::string& cacheDirectory,
                           const TfToken& command, const HdCommandArgs& arguments) {
    if (command == _tokens->flushTextures) {
        param->Push([](hds::Session& session) { session.FlushTextures(); });
        param->Commit();
        return true;
    }
    if (command == _tokens->redice) {
        param->Push([](hds::Session& session) { session.Redice(); });
        param->Commit();
        return true;
    }
    if (command == _tokens->clearCache) {
        try {
            hds::ClearCache(cacheDirectory);
        } catch (const std::exception& error) {
            TF_RUNTIME_ERROR("Stream: %s", error.what());
            return false;
        }
        return true;
    }
    if (command == _tokens->dumpScene) {
        const auto found = arguments.find(_tokens->file.GetString());
        if (found == arguments.end() || !found->second.IsHolding<std::string>() ||
            found->second.UncheckedGet<std::string>().empty()) {
            TF_RUNTIME_ERROR("Stream: dumpScene needs an argument 'file'");
            return false;
        }
        HdStreamPostDump(param, found->second.UncheckedGet<std::string>());
        param->Thread().Call([](hds::Session&) {}); // The file is there when the command returns.
        return true;
    }
    return false;
}

PXR_NAMESPACE_CLOSE_SCOPE

// SPDX-License-Identifier: Apache-2.0
#include "hdStream/hydra/sceneDump.h"

#include "hdStream/hydra/renderParam.h"

#include <pxr/base/tf/getenv.h>

#include <fstream>

PXR_NAMESPACE_OPEN_SCOPE

const std::string& HdStreamDumpFile() {
    static const std::string file = TfGetenv("HDSTREAM_DUMP_SCENE");
    return file;
}

void HdStreamPostDump(HdStreamRenderParam* param, const std::string& file) {
    param->Push([file](hds::Session& session) {
        std::ofstream stream(file, std::ios::binary);
        stream << session.Dump();
        stream.close();
        if (!stream) {
            session.Warn(file, "the scene cannot be written");
        }
    });
    param->Commit();
}

PXR_NAMESPACE_CLOSE_SCOPE

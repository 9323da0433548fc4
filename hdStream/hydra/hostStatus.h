// SPDX-License-Identifier: Apache-2.0
// What a host is told of a render beside Hydra's interface. Blender hands nothing of GetRenderStats
// to its add-ons but a percentage; ours asks here, by the one function that the plug-in exports.
// Explained in docs/hydra.md.
#pragma once

#include "hdStream/hydra/renderParam.h"

#include <pxr/pxr.h>

#include <cstddef>
#include <string>

PXR_NAMESPACE_OPEN_SCOPE

/// The name by which a host asks for a delegate's status. Thread-safe.
class HdStreamHostStatus {
public:
    explicit HdStreamHostStatus(HdStreamRenderParam* param) : _param(param) {}
    ~HdStreamHostStatus() { SetName({}); }
    HdStreamHostStatus(const HdStreamHostStatus&) = delete;
    HdStreamHostStatus& operator=(const HdStreamHostStatus&) = delete;

    /// Replaces the name; empty: nobody asks. Of several delegates of one name the last one
    /// answers.
    void SetName(const std::string& name);

private:
    HdStreamRenderParam* _param;
    std::string _name;
};

PXR_NAMESPACE_CLOSE_SCOPE

extern "C" {
/// Writes the status of the delegate that has the name, as JSON text, with a zero at its end:
/// isDone, error, samplesDone, samplesTotal, fraction, secondsElapsed, warnings (the lines that
/// were printed), statistics (docs/statistics.md, or null). Thread-safe. \return the bytes of the
/// text and its zero; more than `capacity`: nothing was written; 0: there is no such delegate.
__attribute__((visibility("default"))) std::size_t hdStreamStatus(const char* name, char* text,
                                                                  std::size_t capacity);
}

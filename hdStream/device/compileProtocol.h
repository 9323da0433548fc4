// SPDX-License-Identifier: Apache-2.0
// What a rendering process and the processes that compile for it (kernelCompilers.h) say to each
// other: messages over a stream socket, answers in the order of requests.
// Explained in docs/device.md.
#pragma once

#include "hdStream/device/programSource.h"

#include <cstdint>
#include <string>
#include <vector>

namespace hds {

enum class CompileMessage : std::uint32_t {
    Ready,    ///< from the compiler, once, before all else
    Compile,  ///< a device and a program, see CompileRequest
    Binary,   ///< the program's binary
    NotBuilt, ///< why there is none, as text
};

/// The device is the first of the machine that says the same of itself.
struct CompileRequest {
    DeviceProperties device; ///< its texts only
    std::string options;
    std::string text;
};

std::string PackRequest(const DeviceProperties& device, const ProgramSource& source);
/// \return false: it is no request.
bool UnpackRequest(const std::string& payload, CompileRequest* request);

/// Blocks until all is sent, or the time limit of the socket is over. \return false: it was not.
bool SendMessage(int socket, CompileMessage kind, const void* payload, std::size_t bytes);
/// As SendMessage. \return false: there was no whole message, or it is none of ours.
bool ReceiveMessage(int socket, CompileMessage* kind, std::string* payload);

} // namespace hds

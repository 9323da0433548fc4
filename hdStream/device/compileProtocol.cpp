// SPDX-License-Identifier: Apache-2.0
#include "hdStream/device/compileProtocol.h"

#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <cstring>

namespace hds {

namespace {

/// Raised when messages change: a compiler of another version is none of ours.
constexpr char kMagic[8] = {'h', 'd', 's', 'C', 'o', 'm', 'p', '1'};
constexpr std::uint64_t kMostBytes = 1ULL << 30U;

struct Header {
    char magic[8];
    std::uint32_t kind;
    std::uint32_t reserved;
    std::uint64_t bytes;
};

bool SendAll(int socket, const char* data, std::size_t bytes) {
    while (bytes > 0) {
        const ssize_t sent = ::send(socket, data, bytes, MSG_NOSIGNAL);
        if (sent < 0 && errno == EINTR) {
            continue;
        }
        if (sent <= 0) {
            return false;
        }
        data += sent;
        bytes -= static_cast<std::size_t>(sent);
    }
    return true;
}

bool ReceiveAll(int socket, char* data, std::size_t bytes) {
    while (bytes > 0) {
        const ssize_t received = ::recv(socket, data, bytes, 0);
        if (received < 0 && errno == EINTR) {
            continue;
        }
        if (received <= 0) {
            return false;
        }
        data += received;
        bytes -= static_cast<std::size_t>(received);
    }
    return true;
}

} // namespace

std::string PackRequest(const DeviceProperties& device, const ProgramSource& source) {
    std::string payload;
    for (const std::string* part : {&device.platform, &device.name, &device.version,
                                    &device.driverVersion, &source.options, source.text.get()}) {
        const std::uint64_t bytes = part->size();
        payload.append(reinterpret_cast<const char*>(&bytes), sizeof(bytes));
        payload.append(*part);
    }
    return payload;
}

bool UnpackRequest(const std::string& payload, CompileRequest* request) {
    DeviceProperties& device = request->device;
    std::size_t at = 0;
    for (std::string* part : {&device.platform, &device.name, &device.version,
                              &device.driverVersion, &request->options, &request->text}) {
        std::uint64_t bytes = 0;
        if (payload.size() - at < sizeof(bytes)) {
            return false;
        }
        std::memcpy(&bytes, payload.data() + at, sizeof(bytes));
        at += sizeof(bytes);
        if (payload.size() - at < bytes) {
            return false;
        }
        part->assign(payload, at, bytes);
        at += bytes;
    }
    return at == payload.size();
}

bool SendMessage(int socket, CompileMessage kind, const void* payload, std::size_t bytes) {
    Header header{};
    std::memcpy(header.magic, kMagic, sizeof(kMagic));
    header.kind = static_cast<std::uint32_t>(kind);
    header.bytes = bytes;
    return SendAll(socket, reinterpret_cast<const char*>(&header), sizeof(header)) &&
           SendAll(socket, static_cast<const char*>(payload), bytes);
}

bool ReceiveMessage(int socket, CompileMessage* kind, std::string* payload) {
    Header header{};
    if (!ReceiveAll(socket, reinterpret_cast<char*>(&header), sizeof(header)) ||
        std::memcmp(header.magic, kMagic, sizeof(kMagic)) != 0 ||
        header.kind > static_cast<std::uint32_t>(CompileMessage::NotBuilt) ||
        header.bytes > kMostBytes) {
        return false;
    }
    *kind = static_cast<CompileMessage>(header.kind);
    payload->resize(header.bytes);
    return ReceiveAll(socket, payload->data(), payload->size());
}

} // namespace hds

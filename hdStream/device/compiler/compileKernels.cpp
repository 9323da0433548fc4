// SPDX-License-Identifier: Apache-2.0
// hdstreamCompileKernels: compiles OpenCL programs for a process that renders, which starts it and
// talks to it over its standard input (compileProtocol.h). It ends as soon as the other end is
// closed. Exit codes: 0 the other end is closed, 1 what came is no request, 2 started by hand.
// Explained in docs/device.md.
#include "hdStream/device/compileProtocol.h"
#include "hdStream/device/program.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdio>
#include <memory>
#include <thread>

namespace hds {
namespace {

enum ExitCode { kClosed = 0, kNoRequest = 1, kByHand = 2 };

/// The socket, as a descriptor that neither drivers nor what they start know; what they print on
/// standard output goes nowhere.
int TakeSocket() {
    const int socket = ::fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
    const int nothing = ::open("/dev/null", O_RDWR | O_CLOEXEC);
    ::dup2(nothing, STDIN_FILENO);
    ::dup2(nothing, STDOUT_FILENO);
    return socket;
}

bool IsClosed(int socket, int waitMs) {
    pollfd end{socket, POLLRDHUP, 0};
    return ::poll(&end, 1, waitMs) > 0 && (end.revents & (POLLRDHUP | POLLHUP | POLLERR)) != 0;
}

/// Ends the process when the other end is closed, also in the middle of a compilation: the other
/// process does not want it any more, or is gone.
void Watch(int socket) {
    while (!IsClosed(socket, -1)) {
    }
    ::_exit(kClosed);
}

/// \return false: the answer could not be sent.
bool Answer(int socket, const CompileRequest& request, std::shared_ptr<Device>* device) {
    try {
        if (!*device) {
            *device = Device::Create(request.device);
        }
        ProgramSource source;
        source.root = "the program";
        source.text = std::make_shared<const std::string>(request.text);
        source.options = request.options;
        const std::vector<unsigned char> binary = Program(*device, source).Binary();
        return SendMessage(socket, CompileMessage::Binary, binary.data(), binary.size());
    } catch (const Error& error) {
        const std::string text = error.what();
        return SendMessage(socket, CompileMessage::NotBuilt, text.data(), text.size());
    }
}

int Serve(int socket) {
    std::shared_ptr<Device> device;
    CompileMessage kind{};
    std::string payload;
    if (!SendMessage(socket, CompileMessage::Ready, nullptr, 0)) {
        return kClosed;
    }
    while (ReceiveMessage(socket, &kind, &payload)) {
        CompileRequest request;
        if (kind != CompileMessage::Compile || !UnpackRequest(payload, &request)) {
            return kNoRequest;
        }
        if (!Answer(socket, request, &device)) {
            break;
        }
    }
    while (IsClosed(socket, 0)) {
        ::pause(); // the watch ends the process
    }
    return kNoRequest;
}

} // namespace
} // namespace hds

int main() {
    struct stat input {};
    if (::fstat(STDIN_FILENO, &input) != 0 || !S_ISSOCK(input.st_mode)) {
        std::fputs(
            "hdstreamCompileKernels: hdStream starts this program; it does nothing when it is "
            "started by hand\n",
            stderr);
        return hds::kByHand;
    }
    const int socket = hds::TakeSocket();
    std::thread(hds::Watch, socket).detach();
    ::_exit(hds::Serve(socket)); // nothing is to be tidied up: drivers take their time over it
}

// SPDX-License-Identifier: Apache-2.0
// A session that renders on a thread of its own while the front end goes on editing: edits are
// queued, the render stops, applies them, and starts again.
// Explained in docs/session.md.
#pragma once

#include "hdStream/session/session.h"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace hds {

/// How far a render is, as published to front ends. Immutable.
struct RenderStatus {
    std::uint64_t version = 0; ///< of the edits that are rendered; see RenderThread::Version
    Progress progress;
    /// JSON text (docs/statistics.md); soon after an edit that of the render before, or "".
    std::string statistics;
    bool isFinal = false; ///< nothing better will come for this version
    std::string error;    ///< not empty: rendering failed
};

/// One state of the film with the status that it had then. Immutable.
struct FilmImage : RenderStatus {
    std::vector<ImageLayer> layers; ///< may be empty after an error
};

/// Owns a Session and the only thread that touches it. All methods are thread-safe and none of
/// them waits for rendering, except those that say so.
class RenderThread {
public:
    /// An edit runs on the render thread, between renders.
    using Edit = std::function<void(Session&)>;

    /// \param onWarning called on the render thread, once a line.
    explicit RenderThread(Session::WarningSink onWarning = {});
    /// Cancels what runs and waits for its end (some launches, or the prim being planned).
    ~RenderThread();
    RenderThread(const RenderThread&) = delete;
    RenderThread& operator=(const RenderThread&) = delete;

    /// Queues edits, in order, and asks the render to start again with them. Returns the new
    /// version. An empty list changes nothing.
    std::uint64_t Post(std::vector<Edit> edits);

    /// Renders with these settings from now on; starts again when they differ from the present
    /// ones. Nothing is rendered before the first call. Returns the version.
    std::uint64_t SetSettings(const Settings& settings);

    /// Session::Warm on the render thread, as soon as it has nothing to render.
    void Warm(const Settings& settings);

    /// The version of the newest edit or settings.
    std::uint64_t Version() const;

    /// The newest published image, of whatever version; null before the first one.
    std::shared_ptr<const FilmImage> Newest() const;

    /// The newest status, of whatever version; null before the first one. It follows the render
    /// more closely than images do, which take longer to make.
    std::shared_ptr<const RenderStatus> Status() const;

    /// True when the newest image is final and shows the newest version, or nothing is to be
    /// rendered because of Stop.
    bool IsConverged() const;

    /// Waits until then, or for so many seconds.
    void WaitUntilConverged(double seconds) const;

    // --- Control: latched. Edits are accepted in every state and start nothing while stopped. ---
    void Pause(); ///< keeps the film; Resume goes on from there
    void Resume();
    void Stop(bool isBlocking); ///< ends the render; \param isBlocking waits until it has ended
    void Restart();             ///< starts from the first sample, also after Stop
    bool IsPaused() const;
    bool IsStopped() const;

    /// Runs a function on the render thread, between renders, and waits for it. The render then
    /// goes on from the first sample.
    void Call(const Edit& function);

private:
    struct Impl;
    std::unique_ptr<Impl> _impl;
};

} // namespace hds

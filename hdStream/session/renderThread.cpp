// SPDX-License-Identifier: Apache-2.0
#include "hdStream/session/renderThread.h"

#include "hdStream/base/timer.h"
#include "hdStream/session/picturePacing.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <future>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

namespace hds {

namespace {

/// Statuses without a picture are at least this far apart, in seconds.
constexpr double kStatusInterval = 0.1;
/// Statistics are made again when they are so old, in seconds, though edits follow each other fast.
constexpr double kOldestStatistics = 0.5;

} // namespace

struct RenderThread::Impl {
    explicit Impl(Session::WarningSink onWarning) : session(std::move(onWarning)) {}

    // --- Render thread --------------------------------------------------------------------------

    void Run() {
        std::unique_lock<std::mutex> lock(mutex);
        while (true) {
            changed.wait(lock, [&] { return quits || toWarm || !inbox.empty() || HasWork(); });
            if (quits) {
                return;
            }
            if (toWarm) {
                const Settings present = *std::exchange(toWarm, std::nullopt);
                lock.unlock();
                session.Warm(present);
                lock.lock();
                continue;
            }
            ApplyEdits(&lock);
            if (HasWork() && inbox.empty()) {
                RenderVersion(&lock);
            }
        }
    }

    /// Precondition: locked.
    bool IsConverged() const {
        return isStopped || (newest && newest->isFinal && newest->version == version);
    }

    /// Precondition: locked.
    bool HasWork() const {
        return hasSettings && !isStopped && !isPaused && doneVersion != version;
    }

    /// What an edit throws, as for want of memory, is a warning; Call hands it to its caller.
    void ApplyEdits(std::unique_lock<std::mutex>* lock) {
        std::vector<Edit> edits;
        edits.swap(inbox);
        lock->unlock();
        for (const Edit& edit : edits) {
            try {
                edit(session);
            } catch (const std::exception& error) {
                session.Warn("", error.what()); // The thread is the host's process.
            }
        }
        edits.clear(); // frees what they held outside the lock
        lock->lock();
    }

    void RenderVersion(std::unique_lock<std::mutex>* lock) {
        const std::uint64_t rendered = version;
        const Settings present = settings;
        isRendering = true;
        lock->unlock();
        std::shared_ptr<FilmImage> last;
        bool isDone = true;
        try {
            Publisher publisher(this, rendered, present);
            RenderWatch watch;
            watch.isCancelled = [&] { return publisher.IsCancelled(); };
            watch.takesPictures = true;
            const RenderResult result = session.Render(
                present, [&](const Progress& progress) { return publisher.Report(progress); }, {},
                watch);
            isDone = result == RenderResult::Complete;
            if (isDone) {
                last = publisher.MakeLastImage();
            }
        } catch (const std::exception& error) {
            last = std::make_shared<FilmImage>();
            last->version = rendered;
            last->error = error.what();
            last->isFinal = true;
        }
        lock->lock();
        isRendering = false;
        if (isDone) {
            doneVersion = rendered;
            status = last;
            newest = std::move(last);
        }
        changed.notify_all();
    }

    /// Decides when images and statuses are made while one version is rendered.
    class Publisher {
    public:
        Publisher(Impl* impl, std::uint64_t version, const Settings& settings)
            : _impl(impl), _version(version), _isInteractive(settings.interactive),
              _pacing(PassSeconds(settings.interactive, settings.passSeconds)) {
            const std::lock_guard<std::mutex> lock(impl->mutex);
            _statisticsBefore = impl->status ? impl->status->statistics : "";
            if (impl->status && impl->status->isFinal) {
                impl->sinceStatistics = Timer(); // those of a render that is over do not age
            }
        }

        /// The progress callback; waits while paused. \return false when the render is to end.
        bool Report(const Progress& progress) {
            const bool goesOn = _impl->MayGoOn(_version);
            if (!goesOn && !OwesPicture()) {
                return false;
            }
            _progress = progress;
            if (progress.previewStride > 0 &&
                _pacing.IsDue(_timer.Seconds(), progress.previewStride)) {
                PublishImage();
                return goesOn;
            }
            if (_timer.Seconds() >= _nextStatus) {
                PublishStatus();
            }
            return true;
        }

        /// Inside a wave; does not wait while paused.
        bool IsCancelled() const { return !_impl->IsWanted(_version) && !OwesPicture(); }

        std::shared_ptr<FilmImage> MakeLastImage() { return MakeImage(true, true); }

    private:
        std::shared_ptr<FilmImage> MakeImage(bool withFirstHits, bool isFinal) {
            auto image = std::make_shared<FilmImage>();
            image->layers = _impl->session.Layers(withFirstHits);
            image->isFinal = isFinal;
            Fill(image.get());
            return image;
        }

        /// A render that has a film and that someone looks at ends with its first picture at the
        /// earliest, outdated as it is: edits that follow each other faster than that would freeze
        /// the view.
        bool OwesPicture() const {
            return _isInteractive && _pacing.Stride() == 0 && _impl->session.HasImage() &&
                   !_impl->MustEnd();
        }

        /// The render finds first hits before it tells of the first picture of all pixels
        /// (RenderWatch); with them pictures are denoised.
        void PublishImage() {
            const double begin = _timer.Seconds();
            auto image = MakeImage(_progress.previewStride == 1, false);
            const double end = _timer.Seconds();
            _pacing.Made(begin, end, _progress.previewStride);
            _nextStatus = end + kStatusInterval;
            const std::lock_guard<std::mutex> lock(_impl->mutex);
            _impl->status = image;
            _impl->newest = std::move(image);
        }

        void PublishStatus() {
            auto status = std::make_shared<RenderStatus>();
            Fill(status.get());
            _nextStatus = _timer.Seconds() + kStatusInterval;
            const std::lock_guard<std::mutex> lock(_impl->mutex);
            if (status->statistics.empty() && _impl->status) {
                status->statistics = _impl->status->statistics; // while the scene is prepared
            }
            _impl->status = std::move(status);
        }

        void Fill(RenderStatus* status) const {
            status->version = _version;
            status->progress = _progress;
            // Who edits waits for the first pictures, which follow each other fast.
            const bool isSoon =
                _isInteractive && !status->isFinal && _timer.Seconds() < kStatusInterval;
            const bool isOld = _impl->sinceStatistics.Seconds() >= kOldestStatistics;
            if (isSoon && !isOld && !_statisticsBefore.empty()) {
                status->statistics = _statisticsBefore;
            } else if (_impl->session.HasImage()) {
                status->statistics = _impl->session.Statistics();
                _impl->sinceStatistics = Timer();
            }
        }

        Impl* _impl;
        std::uint64_t _version;
        bool _isInteractive;
        PicturePacing _pacing;
        Timer _timer;
        std::string _statisticsBefore; ///< of the render before; empty: there was none
        Progress _progress;
        double _nextStatus = 0.0;
    };

    /// Precondition: locked.
    bool IsAskedToEnd(std::uint64_t rendered) const {
        return quits || isStopped || version != rendered || !inbox.empty();
    }

    /// Waits while paused. \return false when another version, or none, is to be rendered.
    bool MayGoOn(std::uint64_t rendered) {
        std::unique_lock<std::mutex> lock(mutex);
        changed.wait(lock, [&] { return !isPaused || IsAskedToEnd(rendered); });
        return !IsAskedToEnd(rendered);
    }

    /// Whether this version, and no other, is to be rendered.
    bool IsWanted(std::uint64_t rendered) const {
        const std::lock_guard<std::mutex> lock(mutex);
        return !IsAskedToEnd(rendered);
    }

    /// True when nobody wants a picture any more.
    bool MustEnd() const {
        const std::lock_guard<std::mutex> lock(mutex);
        return quits || isStopped;
    }

    // --- State; everything but the session is guarded by the mutex ------------------------------
    Session session;       ///< touched by the render thread only
    Timer sinceStatistics; ///< were made; likewise
    mutable std::mutex mutex;
    std::condition_variable changed;
    std::vector<Edit> inbox;
    std::optional<Settings> toWarm;
    Settings settings;
    bool hasSettings = false;
    bool isPaused = false;
    bool isStopped = false;
    bool isRendering = false;
    bool quits = false;
    std::uint64_t version = 0;
    std::uint64_t doneVersion = 0; ///< rendered to its end
    std::shared_ptr<const FilmImage> newest;
    std::shared_ptr<const RenderStatus> status;
    std::thread thread; ///< last: it uses all the rest
};

RenderThread::RenderThread(Session::WarningSink onWarning)
    : _impl(std::make_unique<Impl>(std::move(onWarning))) {
    _impl->thread = std::thread([impl = _impl.get()] { impl->Run(); });
}

RenderThread::~RenderThread() {
    {
        const std::lock_guard<std::mutex> lock(_impl->mutex);
        _impl->quits = true;
    }
    _impl->changed.notify_all();
    _impl->thread.join();
}

std::uint64_t RenderThread::Post(std::vector<Edit> edits) {
    const std::lock_guard<std::mutex> lock(_impl->mutex);
    if (!edits.empty()) {
        _impl->inbox.insert(_impl->inbox.end(), std::make_move_iterator(edits.begin()),
                            std::make_move_iterator(edits.end()));
        ++_impl->version;
        _impl->changed.notify_all();
    }
    return _impl->version;
}

std::uint64_t RenderThread::SetSettings(const Settings& settings) {
    const std::lock_guard<std::mutex> lock(_impl->mutex);
    if (!_impl->hasSettings || _impl->settings != settings) {
        _impl->settings = settings;
        _impl->hasSettings = true;
        ++_impl->version;
        _impl->changed.notify_all();
    }
    return _impl->version;
}

void RenderThread::Warm(const Settings& settings) {
    const std::lock_guard<std::mutex> lock(_impl->mutex);
    _impl->toWarm = settings;
    _impl->changed.notify_all();
}

std::uint64_t RenderThread::Version() const {
    const std::lock_guard<std::mutex> lock(_impl->mutex);
    return _impl->version;
}

std::shared_ptr<const FilmImage> RenderThread::Newest() const {
    const std::lock_guard<std::mutex> lock(_impl->mutex);
    return _impl->newest;
}

std::shared_ptr<const RenderStatus> RenderThread::Status() const {
    const std::lock_guard<std::mutex> lock(_impl->mutex);
    return _impl->status;
}

bool RenderThread::IsConverged() const {
    const std::lock_guard<std::mutex> lock(_impl->mutex);
    return _impl->IsConverged();
}

void RenderThread::WaitUntilConverged(double seconds) const {
    std::unique_lock<std::mutex> lock(_impl->mutex);
    _impl->changed.wait_for(lock, std::chrono::duration<double>(seconds),
                            [&] { return _impl->IsConverged(); });
}

void RenderThread::Pause() {
    const std::lock_guard<std::mutex> lock(_impl->mutex);
    _impl->isPaused = true;
}

void RenderThread::Resume() {
    {
        const std::lock_guard<std::mutex> lock(_impl->mutex);
        _impl->isPaused = false;
    }
    _impl->changed.notify_all();
}

void RenderThread::Stop(bool isBlocking) {
    std::unique_lock<std::mutex> lock(_impl->mutex);
    _impl->isStopped = true;
    _impl->changed.notify_all();
    if (isBlocking) {
        _impl->changed.wait(lock, [&] { return !_impl->isRendering; });
    }
}

void RenderThread::Restart() {
    {
        const std::lock_guard<std::mutex> lock(_impl->mutex);
        _impl->isStopped = false;
        _impl->isPaused = false;
        ++_impl->version;
    }
    _impl->changed.notify_all();
}

bool RenderThread::IsPaused() const {
    const std::lock_guard<std::mutex> lock(_impl->mutex);
    return _impl->isPaused;
}

bool RenderThread::IsStopped() const {
    const std::lock_guard<std::mutex> lock(_impl->mutex);
    return _impl->isStopped;
}

void RenderThread::Call(const Edit& function) {
    std::promise<void> done;
    {
        const std::lock_guard<std::mutex> lock(_impl->mutex);
        _impl->inbox.emplace_back([&](Session& session) {
            try {
                function(session);
                done.set_value();
            } catch (...) {
                done.set_exception(std::current_exception());
            }
        });
    }
    _impl->changed.notify_all();
    done.get_future().get();
}

} // namespace hds

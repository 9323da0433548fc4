# SPDX-License-Identifier: Apache-2.0
"""Work of the core on a thread of its own, so that Ctrl-C is seen at once."""

import threading


def RunOnThread(work, interruption, onInterrupt):
    """What work() returns, or what it raises. `onInterrupt()` is called once when Ctrl-C is pressed meanwhile; it is to make the
    work end soon."""
    isDone = threading.Event()
    results = []
    errors = []

    def Work():
        try:
            results.append(work())
        except BaseException as error:  # pylint: disable=broad-except
            errors.append(error)
        finally:
            isDone.set()

    thread = threading.Thread(target=Work, name="work", daemon=True)
    thread.start()
    isInterrupted = False
    while not isDone.wait(0.1):
        if interruption.isRequested and not isInterrupted:
            isInterrupted = True
            onInterrupt()
    thread.join()  # it has nothing left to do, and must not do that while the process ends
    if errors and interruption.isRequested:
        # The compiler in the device's driver removes its files at SIGINT, and fails for want of them.
        raise KeyboardInterrupt from errors[0]
    if errors:
        raise errors[0]
    return results[0]

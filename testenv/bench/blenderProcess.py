# SPDX-License-Identifier: Apache-2.0
"""How benches that run inside Blender's Python module end."""

import os
import sys
import traceback


def RunAndExit(main):
    """Runs main() and ends the process with its exit code; a line that SystemExit has goes to the standard error. Blender's own
    clean-up is left out, for it may wait for ever."""
    status = 0
    try:
        main()
    except SystemExit as end:  # with a line where something is missing
        status = end.code or 0
        if isinstance(status, str):
            print(status, file=sys.stderr)
            status = 1
    except BaseException:  # pylint: disable=broad-except
        traceback.print_exc()
        status = 1
    sys.stdout.flush()
    os._exit(status)

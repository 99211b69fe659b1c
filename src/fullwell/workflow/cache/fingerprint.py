"""Whether a file is still the one that was read, by what the file system says of it.

A file whose number, size and both times are as they were when it was read has the content it had. One exception: a file
changed again within the clock's tick keeps its times. So what was read less than two seconds after its last change is
not believed but read and hashed again, as version control systems do.
"""

import time
from pathlib import Path
from typing import Final

from fullwell.raw.remote import RemotePath

TICK_NS: Final = 2_000_000_000
"""The coarsest clock of a file system in use [ns]."""


def fingerprint(path: Path) -> str | None:
    """Return what identifies a file's content for as long as it is not written to.

    Returns
    -------
    str or None
        None where the file is missing, was changed so lately that its times may not tell of another change, or lies at
        a URL, where nothing tells.

    """
    if isinstance(path, RemotePath):
        return None
    try:
        found = path.stat()
    except OSError:
        return None
    if time.time_ns() - max(found.st_mtime_ns, found.st_ctime_ns) < TICK_NS:
        return None
    return f"{found.st_dev}:{found.st_ino}:{found.st_size}:{found.st_mtime_ns}:{found.st_ctime_ns}"

"""What the JIT compiled lies beside the sources and is used again as long as none of them has changed.

The JIT looks at the file of a loop alone. After an update it would go on with loops of other files that were compiled
into it, and fail on names that are gone.
"""

from contextlib import suppress
from pathlib import Path

NOTE = "compiled-from.txt"


def forget_other_code(room: Path) -> None:
    """Delete what was compiled from other sources than those that are there.

    Parameters
    ----------
    room
        Folder of the sources. Where it may not be written, all is left as it is.

    """
    kept = room / "__pycache__"
    note = kept / NOTE
    sources = "\n".join(
        f"{source.name} {source.stat().st_size} {source.stat().st_mtime_ns}" for source in sorted(room.glob("*.py"))
    )
    with suppress(OSError):
        if note.is_file() and note.read_text(encoding="utf-8") == sources:
            return
        kept.mkdir(exist_ok=True)
        for compiled in (*kept.glob("*.nbi"), *kept.glob("*.nbc")):
            compiled.unlink(missing_ok=True)
        note.write_text(sources, encoding="utf-8")

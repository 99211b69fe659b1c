"""What may differ between two runs on the same input: version, command, places, time, host, duration."""

import platform
import sys
import time
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path

from fullwell import __version__
from fullwell.workflow.cache.series_cache import SeriesCache
from fullwell.workflow.options import Options


def run_facts(
    *, study: Path, out: Path, options: Options, started: float, cache: SeriesCache | None = None
) -> Mapping[str, object]:
    """Return what the results document says under ``run`` (RESULTS 2).

    Parameters
    ----------
    study
        What was measured, as the document is to call it.
    out
        Where its results go.
    options
        Of the measurement.
    started
        When it began, by the monotonic clock [s].
    cache
        Where finished series were looked for and kept.

    """
    return {
        "version": __version__,
        "command": list(sys.argv),
        "study": str(study),
        "out": str(out),
        "time": datetime.now(UTC).isoformat(timespec="seconds"),
        "host": platform.node(),
        "duration_s": round(time.monotonic() - started, 3),
        "workers": options.workers,
        "cache": None if cache is None else cache.told,
    }

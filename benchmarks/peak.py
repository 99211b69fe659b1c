"""Reduce a folder in a process of its own and print the largest memory it took [byte]."""

import sys
from pathlib import Path

from benchmarks.reduction import WORKERS
from benchmarks.studies import study_in
from fullwell.workflow.reduce import reduce_study


def peak_bytes() -> int:
    """Return the peak of this process since it began; on Linux getrusage would count the parent's too."""
    status = Path("/proc/self/status")
    if status.exists():
        line = next(line for line in status.read_text(encoding="ascii").splitlines() if line.startswith("VmHWM"))
        return int(line.split()[1]) * 1024
    import resource  # noqa: PLC0415 - not there on Windows

    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else peak * 1024


if __name__ == "__main__":
    reduce_study(study_in(Path(sys.argv[1])), workers=WORKERS)
    print(peak_bytes())

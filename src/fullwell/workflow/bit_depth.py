"""Whether the codes of the frames fit the bit depth that somebody stated."""

from collections.abc import Iterable

from fullwell.findings import Finding, Severity
from fullwell.frames.series import Study
from fullwell.statistics.series import SeriesStatistics


def bit_depth_findings(study: Study, statistics: Iterable[SeriesStatistics]) -> tuple[Finding, ...]:
    """Return a warning where frames hold codes above the highest that the manifest's or user's bit depth allows.

    A file's own bit depth is not judged: codes may lie above it once they are linearized.

    Parameters
    ----------
    study
        Its camera holds the stated bit depth, None where nobody stated one.
    statistics
        Of every series.

    """
    stated = study.camera.bit_depth
    if stated is None:
        return ()
    highest = max((int(plane.tiles.highest.max()) for one in statistics for plane in one.planes), default=0)
    if highest < 2**stated:
        return ()
    message = (
        f"frames hold codes up to {highest} DN, above {2**stated - 1} DN, the highest of the stated bit depth "
        f"{stated}: correct bit_depth in [camera]"
    )
    return (Finding(code="codes-above-bit-depth", severity=Severity.WARNING, message=message),)

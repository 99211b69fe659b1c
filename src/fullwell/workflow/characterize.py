"""The main verb: a folder of raw frames becomes a characterized sensor."""

import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from fullwell.errors import UsageError
from fullwell.figures.results import Results
from fullwell.files import replaced_folder
from fullwell.frames.series import MEASURED_KINDS, Kind, Study
from fullwell.frames.study import load_study
from fullwell.raw.cfa import cell
from fullwell.report.write import check_target, write_files
from fullwell.workflow.cache.opening import opened_cache
from fullwell.workflow.cache.series_cache import SeriesCache
from fullwell.workflow.cluster import connected
from fullwell.workflow.executor import Progress, old_objects_aside, one_algebra_thread, short_turns
from fullwell.workflow.isos import IsoReader
from fullwell.workflow.memory import keep_large_apart
from fullwell.workflow.options import Options
from fullwell.workflow.plan import Cluster
from fullwell.workflow.run import run_facts

if TYPE_CHECKING:
    from fullwell.workflow.spanning import Measurement

LARGEST_TILE = 64
SMALLEST_TILE = 8


def characterize(path: Path, out: Path, *, options: Options, progress: Progress | None = None) -> Results:
    """Measure a study and write what was found into a folder.

    Parameters
    ----------
    path
        A study folder, a manifest or an EMVA 1288 descriptor.
    out
        Folder to write; replaced only if it is empty or holds results of ours.
    options
        What to measure and how.
    progress
        Told of every frame, and again of those read a second time; None for silence.

    Returns
    -------
    Results
        What was written.

    Raises
    ------
    UsageError
        The path holds nothing to measure, an option does not fit it, or ``out`` must not be replaced.

    """
    check_target(out)
    _refuse_to_replace(path, out)
    started = time.monotonic()
    study = _study_to_measure(path, options)
    cache = opened_cache(options, out=out)
    with replaced_folder(out) as folder:
        with connected(options.dask, workers=options.workers) as cluster:
            measurement = _measure(
                study,
                options=options,
                progress=progress,
                folder=folder,
                beside=folder.parent,
                cache=cache,
                cluster=cluster,
            )
        if cache is not None:
            cache.sweep()
        run = run_facts(study=path, out=out, options=options, started=started, cache=cache)
        results = replace(measurement.results, run=run)
        write_files(results, folder, pictures=measurement.pictures)
    return results


def _refuse_to_replace(path: Path, out: Path) -> None:
    """Refuse to write results over the study they come from."""
    study, target = path.resolve(), out.resolve()
    if study == target or target in study.parents:
        raise UsageError(f"{out} holds the study {path}, and results would replace it; name another folder with -o")


def measure(
    path: Path,
    *,
    options: Options,
    progress: Progress | None = None,
    folder: Path | None = None,
    beside: Path | None = None,
) -> "Measurement":
    """Measure a study in this process.

    Parameters
    ----------
    path, options, progress
        As `characterize`.
    folder
        Where ``maps/`` and ``tables/`` are written; None writes neither, and takes no pictures.
    beside
        Where sums go that are too large for the memory, until they are measured; None: where the system keeps what is
        temporary.

    """
    study = _study_to_measure(path, options)
    return _measure(study, options=options, progress=progress, folder=folder, beside=beside)


def _study_to_measure(path: Path, options: Options) -> Study:
    study = load_study(path, options.selection)
    if not any(one.kind in (*MEASURED_KINDS, Kind.CHART) for one in study.series):
        raise UsageError(
            f"{path} holds no flat, dark, bias or chart frames to measure; name the folders flat, dark, bias and "
            "chart, or write a study.toml with `fullwell index`"
        )
    return study


def _measure(
    study: Study,
    *,
    options: Options,
    progress: Progress | None,
    folder: Path | None,
    beside: Path | None,
    cache: SeriesCache | None = None,
    cluster: Cluster | None = None,
) -> "Measurement":
    """Measure a study, finished series from a cache where there is one, frames read by a cluster where there is one."""
    measured = replace(study, series=tuple(one for one in study.series if one.kind in MEASURED_KINDS))
    tile = options.tile or default_tile(study)
    keep_large_apart()
    with (
        tempfile.TemporaryDirectory(prefix="sums-", dir=beside, ignore_cleanup_errors=True) as scratch,
        one_algebra_thread(),
        short_turns(),
        old_objects_aside(),
    ):
        reader = IsoReader(
            study=study,
            options=options,
            tile=tile,
            folder=folder,
            scratch=Path(scratch),
            progress=progress,
            cache=cache,
            cluster=cluster,
        )
        found = reader.measure(measured)
        from fullwell.workflow.spanning import measure_spanning  # noqa: PLC0415 - loads while files are read

        drawn = folder is not None
        return measure_spanning(study, found, options=options, tile=tile, drawn=drawn, progress=progress)


def default_tile(study: Study) -> int:
    """Return the edge of a tile: 64 pixels of a plane, or an eighth of its shorter side where that is less, at least 8.

    A quadratic surface over a tile must follow the shading, or what is left of it counts as fixed pattern.
    """
    shorter = min(study.width, study.height) // cell(study.cfa)
    return max(SMALLEST_TILE, min(LARGEST_TILE, shorter // 8))

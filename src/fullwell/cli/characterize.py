"""``fullwell characterize``: a folder of raw frames becomes a characterized sensor."""

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from fullwell.cli.options import (
    Black,
    Cache,
    CameraFacts,
    Cfa,
    Crop,
    Dask,
    DryRun,
    Exposures,
    Headerless,
    Isos,
    Json,
    LegacyBlack,
    NoCache,
    Only,
    Out,
    Profiles,
    Quiet,
    Recheck,
    StudyPath,
    Tile,
    Verbose,
    Version,
    White,
    Workers,
)
from fullwell.cli.progress import shown_progress
from fullwell.cli.status import guarded, status_of

if TYPE_CHECKING:
    from fullwell.figures.results import Results
    from fullwell.frames.selection import Selection
    from fullwell.workflow.options import CacheChoice, Options


def characterize(
    path: StudyPath,
    *,
    out: Out = None,
    iso: Isos = None,
    exposure: Exposures = None,
    only: Only = None,
    crop: Crop = None,
    tile: Tile = None,
    cfa: Cfa = None,
    headerless: Headerless = None,
    black: Black = None,
    white: White = None,
    camera: CameraFacts = None,
    profile: Profiles = None,
    legacy_black: LegacyBlack = "kept",
    workers: Workers = None,
    dask: Dask = None,
    cache: Cache = None,
    no_cache: NoCache = False,
    recheck: Recheck = False,
    dry_run: DryRun = False,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
    _version: Version = False,
) -> None:
    """Measure a sensor."""
    with guarded(verbose=verbose):
        from fullwell.cli.parsing import cache_from, selection_from  # noqa: PLC0415 - heavy, `--help` does not need it

        selection = selection_from(
            isos=iso,
            exposures=exposure,
            only=only,
            cfa=cfa,
            black=black,
            white=white,
            camera=camera,
            crop=crop,
            headerless=headerless,
        )
        kept = cache_from(cache, no_cache=no_cache, out=out, recheck=recheck)
        options = _options(
            selection, tile=tile, workers=workers, dask=dask, cache=kept, profile=profile, legacy_black=legacy_black
        )
        raise typer.Exit((_show_plan if dry_run else _measure)(path, out, options, as_json=as_json, quiet=quiet))


def _options(
    selection: "Selection",
    *,
    tile: int | None,
    workers: int | None,
    dask: str | None,
    cache: "CacheChoice | None",
    profile: list[str] | None,
    legacy_black: str,
) -> "Options":
    from fullwell.cli.parsing import legacy_black_from, tile_from  # noqa: PLC0415 - as above
    from fullwell.workflow.measure.emva.measure import profiles_named  # noqa: PLC0415 - as above
    from fullwell.workflow.options import Options  # noqa: PLC0415 - as above

    return Options(
        selection=selection,
        tile=tile_from(tile),
        workers=workers or os.cpu_count() or 1,
        profiles=() if profile is None else profiles_named(",".join(profile)),
        dask=dask,
        cache=cache,
        legacy_black_subtracted=legacy_black_from(legacy_black),
    )


def _show_plan(path: Path, _out: Path | None, options: "Options", *, as_json: bool, quiet: bool) -> int:
    del quiet  # it is what was asked for
    from fullwell.frames.study import load_study  # noqa: PLC0415 - heavy, and `--help` does not need it

    study = load_study(path, options.selection)
    if as_json:
        from fullwell.cli.plan import plan_json  # noqa: PLC0415 - as above

        sys.stdout.write(plan_json(study))
    else:
        from rich.console import Console  # noqa: PLC0415 - as above

        from fullwell.cli.tables import print_study  # noqa: PLC0415 - as above

        print_study(Console(file=sys.stdout), study)
    return status_of(study.findings)


def _measure(path: Path, out: Path | None, options: "Options", *, as_json: bool, quiet: bool) -> int:
    from fullwell.errors import UsageError  # noqa: PLC0415 - as above

    if out is None:
        raise UsageError("Name a folder for the results with -o OUT (or look first with --dry-run).")
    from fullwell.workflow.characterize import characterize as run  # noqa: PLC0415 - as above

    with shown_progress(quiet=quiet) as progress:
        results = run(path, out, options=options, progress=progress)
    if as_json:
        from fullwell.report.document import results_json  # noqa: PLC0415 - as above

        sys.stdout.write(results_json(results))
    elif not quiet:
        _tell(results, out)
    return status_of(results.findings)


def _tell(results: "Results", out: Path) -> None:
    from rich.console import Console  # noqa: PLC0415 - as above

    from fullwell.cli.summary import print_summary  # noqa: PLC0415 - as above

    print_summary(Console(file=sys.stdout), results, out=out)

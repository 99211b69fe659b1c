"""``fullwell shading fit``: a map per flat burst, and every model's coefficients with their errors."""

import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from fullwell.errors import UsageError
from fullwell.figures.results import Row
from fullwell.findings import Finding
from fullwell.fit.shading.extent import optical_axis
from fullwell.fit.shading.surface import ShadingModel
from fullwell.frames.series import MEASURED_KINDS, Kind, Study
from fullwell.frames.study import load_study
from fullwell.units import Measured
from fullwell.workflow.characterize import default_tile
from fullwell.workflow.duplicates import reduce_without_copies
from fullwell.workflow.executor import Progress
from fullwell.workflow.iso_maps import shading_file
from fullwell.workflow.maps import save_shading_map
from fullwell.workflow.measure.bursts import group_by_iso
from fullwell.workflow.measure.iso import measure_iso
from fullwell.workflow.measure.section import over_isos
from fullwell.workflow.measure.shading import BurstShading, ChannelShading
from fullwell.workflow.options import Options
from fullwell.workflow.shading.coefficients import coefficients_csv
from fullwell.workflow.shading.folder import (
    ShadingOutcome,
    check_shading_target,
    shading_folder,
    write_document,
)

COEFFICIENTS: Final = "coefficients.csv"
MAPS: Final = "maps"
_CONCERNED: Final = ("black-clipped", "black-level-unknown", "black-levels-disagree", "drift", "flats-saturated")
"""Findings about an ISO, beside those on shading itself, that tell what a map is worth."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MeasuredShading:
    """The shading of every flat burst of a study.

    Parameters
    ----------
    study
        Its frames and facts.
    bursts
        By ascending ISO and exposure.
    rows
        Corner, edges and residuals of every model.
    findings
        What is to be said about the flats and what was left out of them.

    """

    study: Study
    bursts: tuple[BurstShading, ...]
    rows: tuple[Row, ...]
    findings: tuple[Finding, ...]


def fit_maps(path: Path, out: Path, *, options: Options, progress: Progress | None = None) -> ShadingOutcome:
    """Fit the shading of a study's flats and write its maps into a folder.

    Parameters
    ----------
    path
        A study folder or a manifest with flats; darks give the black level where there are any.
    out
        Folder to write: ``maps/shading_*.npz``, ``coefficients.csv``, ``shading.json``.
    options
        What to measure and how.
    progress
        Told of every frame.

    Raises
    ------
    UsageError
        Where no shading can be fitted, or ``out`` must not be replaced.

    """
    started = time.monotonic()
    check_shading_target(out, path)
    measured = measure_study(path, options=options, progress=progress)
    with shading_folder(out, path) as folder:
        (folder / MAPS).mkdir()
        for one in measured.bursts:
            save_shading_map(folder / MAPS, shading_file(measured.study, one))
        (folder / COEFFICIENTS).write_text(coefficients_csv(measured.bursts), encoding="utf-8", newline="\n")
        document = write_document(
            folder,
            "fit",
            {"study": str(path), "bursts": [_said(measured, one) for one in measured.bursts]},
            findings=measured.findings,
            options=options,
            study=path,
            out=out,
            started=started,
        )
    return ShadingOutcome(out=out, document=document, findings=measured.findings)


def measure_study(path: Path, *, options: Options, progress: Progress | None = None) -> MeasuredShading:
    """Fit the shading of every flat burst of a study, as `characterize` does.

    Raises
    ------
    UsageError
        Where there are no flats, or none can be fitted.

    """
    study = load_study(path, options.selection)
    series = tuple(one for one in study.series if one.kind in MEASURED_KINDS)
    if not any(one.kind is Kind.FLAT for one in series):
        raise UsageError(f"{path} holds no flat frames; shading is fitted to frames of an evenly lit field (flat).")
    measured = replace(study, series=series)
    with tempfile.TemporaryDirectory(prefix="sums-", ignore_cleanup_errors=True) as scratch:
        reduction = reduce_without_copies(
            measured,
            workers=options.workers,
            tile=options.tile or default_tile(study),
            progress=progress,
            keep=MEASURED_KINDS,
            scratch=Path(scratch),
        )
        groups = group_by_iso(measured, reduction.statistics, reduction.sums, reduction.first)
        isos = [measure_iso(study, group, workers=options.workers) for group in groups if group.flats]
        bursts = tuple(one for iso in isos for one in iso.shadings if len(one.channels) == len(iso.bursts.channels))
        rows = tuple(row for iso in isos for row in iso.section.rows if row.quantity.startswith("shading_"))
        own = [(one.bursts, replace(one.section, findings=_concerned(one.section.findings))) for one in isos]
        findings = (*study.findings, *reduction.findings, *over_isos(own))
    if not bursts:
        reasons = "; ".join(one.message for one in findings if one.code == "shading-not-measured")
        raise UsageError(f"The shading of {path} cannot be fitted. {reasons or 'No flat burst could be read.'}")
    return MeasuredShading(study=study, bursts=bursts, rows=rows, findings=findings)


def _concerned(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    return tuple(one for one in findings if one.code.startswith("shading-") or one.code in _CONCERNED)


def _said(measured: MeasuredShading, burst: BurstShading) -> Mapping[str, object]:
    found = [row for row in measured.rows if (row.iso, row.exposure_s) == (burst.iso, burst.burst.exposure_s)]
    return {
        "map": f"{MAPS}/{shading_file(measured.study, burst).stem}.npz",
        "iso": burst.iso,
        "exposure_s": burst.burst.exposure_s,
        "frames": burst.burst.frames,
        "channels": [_channel(one, [row for row in found if row.channel == one.channel]) for one in burst.channels],
    }


def _channel(one: ChannelShading, rows: Sequence[Row]) -> Mapping[str, object]:
    return {
        "channel": one.channel,
        "chosen": one.fits.chosen,
        "black_level_dn": one.black_dn,
        "maximum_dn": one.fits.best.maximum_dn,
        "centre": {"row": one.fits.best.centre[0], "column": one.fits.best.centre[1], "unit": "pixel of the plane"},
        "models": [
            _model(model, [row for row in rows if row.method == model.name]) for model in one.fits.models.values()
        ],
    }


def _model(model: ShadingModel, rows: Sequence[Row]) -> Mapping[str, object]:
    return {
        "model": model.name,
        "terms": model.effective_terms,
        "cross_validation": model.gcv,
        "cross_validation_error": model.gcv_error,
        "misfit": model.misfit,
        "optical_axis": _axis(model),
        **{row.quantity.removeprefix("shading_"): _number(row.measured) for row in rows},
    }


def _axis(model: ShadingModel) -> Mapping[str, object] | None:
    """Return where the axis of the lens meets the plane, and the focal length; None of models that know no axis."""
    axis = optical_axis(model)
    if axis is None:
        return None
    focal = None if axis.focal_length is None else _number(axis.focal_length)
    return {"row": _number(axis.row), "column": _number(axis.column), "focal_length": focal}


def _number(measured: Measured) -> Mapping[str, object]:
    return {"value": measured.value, "std_error": measured.std_error, "ci95": measured.ci95, "unit": measured.unit}

"""Noise models converted: what is given, in every dialect, as figures with their errors and as a document."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, cast

from fullwell.errors import UsageError
from fullwell.figures.noise_model import (
    DSNU_DN2,
    DSNU_E2,
    PROFILE_SCALE,
    READ_DN2,
    READ_E2,
    SATURATION_DN,
    SATURATION_E,
    GivenModel,
    native_values,
)
from fullwell.figures.noise_translation import Translation, translated
from fullwell.findings import Finding, Severity
from fullwell.report.document import Plain, plain, row_record
from fullwell.workflow.model_figures import StatedFigures, models_of_figures
from fullwell.workflow.model_files import models_of_file

SCHEMA: Final = "fullwell-model/1"


@dataclass(frozen=True, slots=True, kw_only=True)
class ConvertedModel:
    """A noise model and its figures, dialect after dialect."""

    model: GivenModel
    figures: tuple[Translation, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Conversion:
    """What a conversion came to.

    Parameters
    ----------
    given
        What was given: the file's name, or the figures by name (JSON-ready).
    models
        One a channel and ISO.
    findings
        What is to be said about them.

    """

    given: Mapping[str, object]
    models: tuple[ConvertedModel, ...]
    findings: tuple[Finding, ...]


def convert_figures(figures: StatedFigures) -> Conversion:
    """Convert a noise model that figures state.

    Raises
    ------
    UsageError
        Where the figures make no model; the sentence names the option.

    """
    given: dict[str, object] = {**figures.stated()}
    if figures.noise_profile:
        given["noise_profile"] = figures.noise_profile
    return _converted(given, models_of_figures(figures))


def convert_file(path: Path, *, isos: Sequence[float] = ()) -> Conversion:
    """Convert the noise models of results.json, of a folder with one, or of a raw file's NoiseProfile.

    Parameters
    ----------
    path
        The file or folder.
    isos
        The only ISOs to convert; all where empty.

    Raises
    ------
    UsageError
        Where there is no noise model, or none at these ISOs.

    """
    models = models_of_file(path)
    chosen = tuple(model for model in models if not isos or model.iso in isos)
    if not chosen:
        known = ", ".join(sorted({f"{model.iso:g}" for model in models if model.iso is not None}))
        raise UsageError(f"{path} has no noise model at these ISOs; it has {known or 'none with an ISO'}.")
    return _converted({"file": path}, chosen)


def document(conversion: Conversion) -> Mapping[str, Plain]:
    """Return a conversion as JSON can hold it."""
    models: list[object] = [
        {
            "channel": one.model.channel,
            "iso": one.model.iso,
            "conventions": {
                "digital_maximum": one.model.conventions.digital_maximum,
                "digital_maximum_is": one.model.conventions.digital_maximum_is,
                "white_level": one.model.conventions.white_level,
                "black_level": one.model.conventions.black_level,
                "signal_range": one.model.conventions.signal_range,
                "step": one.model.conventions.step,
                "exposure_s": one.model.conventions.exposure_s,
            },
            "figures": [
                {
                    "dialect": figure.dialect,
                    "symbol": figure.symbol,
                    "equation": figure.equation,
                    **row_record(figure.row),
                }
                for figure in one.figures
            ],
        }
        for one in conversion.models
    ]
    findings = [
        {"code": one.code, "severity": one.severity, "message": one.message, "files": one.files}
        for one in conversion.findings
    ]
    return cast(
        "Mapping[str, Plain]",
        plain({"schema": SCHEMA, "given": conversion.given, "models": models, "findings": findings}),
    )


def _converted(given: Mapping[str, object], models: Sequence[GivenModel]) -> Conversion:
    converted = tuple(ConvertedModel(model=model, figures=translated(model)) for model in models)
    return Conversion(given=given, models=converted, findings=tuple(_findings(models)))


def _findings(models: Sequence[GivenModel]) -> Iterator[Finding]:
    """Yield what limits the conversion, each thing once."""
    if any(model.conventions.black_level is None or model.conventions.white_level is None for model in models):
        yield _info(
            "range-unknown",
            "The black level is not known: S and O of the NoiseProfile are relative to D. With --white and --black "
            "they are relative to white minus black, as a DNG wants them.",
        )
    if any(model.given.keys().isdisjoint({SATURATION_E, SATURATION_DN}) for model in models):
        yield _info(
            "saturation-unknown",
            "Saturation is not known: the end of the range stands for it (adc-limited), though a pixel may be full "
            "before. Beside figures, --saturation-capacity or --saturation-dn states it.",
        )
    if any(model.given.keys().isdisjoint({READ_E2, READ_DN2, DSNU_E2, DSNU_DN2}) for model in models):
        yield _info(
            "dsnu-unknown",
            "The noise in the dark of one frame holds DSNU, which is not known: read noise still holds it (mixed). "
            "Give --dsnu or --dsnu-dn.",
        )
    yield from _about_parts(models)
    yield from _about_fixed_pattern(models)


def _about_parts(models: Sequence[GivenModel]) -> Iterator[Finding]:
    natives = [native_values(model) for model in models if model.given.keys().isdisjoint({READ_E2, READ_DN2})]
    if any(native.read_e2 <= 0.0 < native.dark_dn2 for native in natives):
        yield Finding(
            code="parts-exceed-whole",
            severity=Severity.WARNING,
            message=(
                "Rounding (q^2/12), DSNU and dark current together are more than the noise in the dark: nothing is "
                "left for read noise. Check --step, --digital-maximum and --exposure."
            ),
        )


def _about_fixed_pattern(models: Sequence[GivenModel]) -> Iterator[Finding]:
    if any(PROFILE_SCALE in model.given and native_values(model).fixed is None for model in models):
        yield _info(
            "fixed-pattern-unknown",
            "A NoiseProfile has no fixed pattern noise: k_fpn and the total SNR at saturation are not known. "
            "Give --prnu.",
        )
    shares = [share for model in models if (share := _fixed_share(model)) > 0.0]
    if shares:
        yield _info(
            "fixed-pattern-left-out",
            f"The NoiseProfile has no term for fixed pattern noise: it leaves out {100.0 * max(shares):.2g} % of the "
            "variance at the end of the range.",
        )


def _fixed_share(model: GivenModel) -> float:
    """Return what C is of the variance at the end of the range [1]."""
    native, end = native_values(model), model.conventions.signal_range
    fixed = (native.fixed or 0.0) * end**2
    return fixed / (native.dark_dn2 + native.system_gain * end + fixed)


def _info(code: str, message: str) -> Finding:
    return Finding(code=code, severity=Severity.INFO, message=message)

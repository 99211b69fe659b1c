"""What the standard asks for and these data do not hold, each with its reason."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from fullwell.figures.results import Results, Row
from fullwell.report.datasheet.contents import Missing
from fullwell.report.datasheet.facts import record
from fullwell.report.datasheet.graphs import Curves

_LIGHT: Final = "State photons, or the irradiance with wavelength and pixel area: nothing here tells them."
_SWEEP: Final = "It needs a sweep of exposures with pairs of frames up to saturation; the findings say what is missing."
_STACKS: Final = "It needs a stack of dark frames and one at half saturation, at one exposure time."
_RATE: Final = "It needs pairs of dark frames at six exposure times or more."
_AREA: Final = "It needs the size of a pixel: pixel_pitch_um or pixel_area_um2 in [camera]."
_STEPS: Final = 50


@dataclass(frozen=True, slots=True, kw_only=True)
class _Wish:
    title: str
    quantity: str
    reason: str


_WISHES: Final = (
    _Wish(title="Quantum efficiency", quantity="quantum_efficiency", reason=_LIGHT),
    _Wish(title="Responsivity", quantity="responsivity", reason=_LIGHT),
    _Wish(title="Overall system gain", quantity="system_gain", reason=_SWEEP),
    _Wish(title="Temporal dark noise", quantity="dark_noise", reason=_SWEEP),
    _Wish(title="Saturation capacity", quantity="saturation_capacity", reason=_SWEEP),
    _Wish(title="Absolute sensitivity threshold", quantity="sensitivity_threshold", reason=_SWEEP),
    _Wish(title="Dynamic range", quantity="dynamic_range", reason=_SWEEP),
    _Wish(title="Maximum SNR", quantity="snr_max", reason=_SWEEP),
    _Wish(title="DSNU", quantity="dsnu", reason=_STACKS),
    _Wish(title="PRNU", quantity="prnu", reason=_STACKS),
    _Wish(title="Linearity error", quantity="linearity_error", reason=_SWEEP),
    _Wish(title="Dark current from the mean", quantity="dark_current", reason=_RATE),
    _Wish(title="Dark current from the variance", quantity="dark_current_from_variance", reason=_RATE),
    _Wish(title="Figures per area", quantity="saturation_capacity_per_area", reason=_AREA),
)
_LINEARITY_OF_PACKAGE: Final = "linearity_error_min"


def reason_of(quantity: str) -> str:
    """Return why a figure may be missing, empty for one that the standard does not ask for."""
    name = quantity.split("_row", maxsplit=1)[0].split("_column", maxsplit=1)[0].split("_pixel", maxsplit=1)[0]
    if name.endswith("_per_area"):
        return _AREA
    if name == "conversion_factor":
        name = "system_gain"
    if name == "inverse_snr_max":
        name = "snr_max"
    return next((wish.reason for wish in _WISHES if wish.quantity == name), "")


def missing_items(results: Results, rows: Sequence[Row], points: Sequence[tuple[str, Curves]]) -> tuple[Missing, ...]:
    """Return what is missing of the mandatory measurements and statements.

    Parameters
    ----------
    results
        Of the whole study.
    rows
        Of the profile.
    points
        Title and curves of each operation point.

    """
    return (*_figures(rows), *_curves(points), *_statements(results))


def _figures(rows: Sequence[Row]) -> Iterator[Missing]:
    held = {row.quantity for row in rows}
    for wish in _WISHES:
        told = wish.quantity == "linearity_error" and _LINEARITY_OF_PACKAGE in held
        if wish.quantity not in held and not told:
            yield Missing(item=wish.title, reason=wish.reason)


def _curves(points: Sequence[tuple[str, Curves]]) -> Iterator[Missing]:
    for title, curves in points:
        for curve, item in (
            ("emva_spectrogram_dsnu", "spectrograms"),
            ("emva_profile_dsnu", "profiles"),
            ("emva_histogram_dsnu", "defect histograms"),
        ):
            if curves.table(curve) is None:
                yield Missing(item=f"{title}: {item}", reason=_STACKS)
        sweep = curves.table("emva_sweep")
        if sweep is not None:
            steps = max(len(part) for _, part in sweep.split("channel"))
            if steps < _STEPS:
                reason = f"The sweep has {steps} steps; the standard asks for {_STEPS} or more, equally spaced."
                yield Missing(item=f"{title}: exposure steps", reason=reason)


def _statements(results: Results) -> Iterator[Missing]:
    emva, light = record(results, "emva"), record(results, "light")
    for item, table, name, key in (
        ("Date of the measurement", emva, "[emva]", "date"),
        ("Type of data presented", emva, "[emva]", "data_type"),
        ("Wavelength of the light", light, "[light]", "wavelength_nm"),
        ("Spectral width of the light", light, "[light]", "fwhm_nm"),
        ("Non-uniformity of the light ΔE", light, "[light]", "nonuniformity_percent"),
        ("Irradiance calibration accuracy", light, "[light]", "calibration_error_percent"),
    ):
        if table.get(key) in {None, ""}:
            yield Missing(item=item, reason=f"State {key} in {name} of study.toml.")

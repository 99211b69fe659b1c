"""What the general page and the head of a summary page say: as stated in the manifest, "not stated" otherwise."""

from collections.abc import Mapping, Sequence
from typing import Final, cast

from fullwell.figures.results import Results, Row
from fullwell.report.datasheet.contents import Fact
from fullwell.report.numbers import show_exposure, show_plain

NOT_STATED: Final = "not stated"
_CONTROL: Final = {"time": "by exposure time (I)", "light": "by irradiance (II)", "pulse": "by pulse length (III)"}

Record = Mapping[str, object]

# label, key of [emva], unit
_BASIC: Final = (
    ("Vendor", "vendor", ""),
    ("Model", "model", ""),
    ("Serial number", "serial_number", ""),
    ("Type of data presented", "data_type", ""),
    ("Number and selection of samples", "data_type_definition", ""),
    ("Sensor type", "sensor_type", ""),
    ("Sensor diagonal", "sensor_diagonal_mm", "mm"),
    ("Lens category", "lens_category", ""),
)
_CCD: Final = (("Readout type", "readout_type", ""), ("Transfer type", "transfer_type", ""))
_CMOS: Final = (("Shutter type", "shutter_type", ""), ("Overlap capabilities", "overlap_capabilities", ""))
_AFTER: Final = (
    ("Maximum readout rate", "maximum_readout_rate", ""),
    ("Dark current compensation", "dark_current_compensation", ""),
    ("Interface", "interface", ""),
    ("Optional parts measured", "optional_parts", ""),
)
_SETTINGS: Final = (
    ("Frame rate", "frame_rate_hz", "Hz"),
    ("Data transfer mode", "data_transfer_mode", ""),
    ("Gain setting", "gain_setting", ""),
)
_TEMPERATURES: Final = (
    ("Environmental temperature", "environment_temperature_c", "°C"),
    ("Camera body temperature", "body_temperature_c", "°C"),
)


def record(results: Results, name: str) -> Record:
    """Return a table of the study's description, empty where there is none."""
    found = results.study.get(name)
    return cast("Record", found) if isinstance(found, Mapping) else {}


def text_of(value: object, unit: str = "") -> str:
    """Return a stated value as text, empty where nobody stated it."""
    if value is None or value == "":
        return ""
    text = show_plain(float(value)) if isinstance(value, (int, float)) and not isinstance(value, bool) else str(value)
    return f"{text} {unit}".rstrip()


def stated(label: str, text: str) -> Fact:
    """Return a fact, or that it is not stated."""
    return Fact(label=label, text=text or NOT_STATED, stated=bool(text))


def basic_facts(results: Results) -> tuple[Fact, ...]:
    """Return the basic information of the general page, in the standard's order."""
    emva, camera = record(results, "emva"), record(results, "camera")
    size = f"{results.study.get('width')} × {results.study.get('height')}"
    pitch = text_of(camera.get("pixel_pitch_um"))
    area = text_of(camera.get("pixel_area_um2"), "µm²")
    kind = str(emva.get("sensor_type") or "").upper()
    technology = _CCD if kind == "CCD" else _CMOS
    return (
        *(stated(label, text_of(emva.get(key), unit)) for label, key, unit in _BASIC),
        stated("Resolution", size),
        stated("Pixel size", f"{pitch} µm × {pitch} µm" if pitch else area),
        *(stated(label, text_of(emva.get(key), unit)) for label, key, unit in (*technology, *_AFTER)),
        stated("Bits of a code", text_of(results.code_bits)),
        stated("Colour filter array", str(results.study.get("cfa") or "")),
    )


def equipment_facts(results: Results, *, release: str) -> tuple[Fact, ...]:
    """Return test equipment and release of the general page."""
    emva, light = record(results, "emva"), record(results, "light")
    return (
        stated("Release of the standard", release),
        stated("Date of the measurement", text_of(emva.get("date"))),
        stated("Measured by", text_of(emva.get("company"))),
        stated("Test equipment", text_of(emva.get("equipment"))),
        stated("Light source", text_of(emva.get("light_source"))),
        stated("Wavelength, centroid", text_of(light.get("wavelength_nm"), "nm")),
        stated("Wavelength, FWHM", text_of(light.get("fwhm_nm"), "nm")),
        stated("f-number of the set-up", text_of(emva.get("f_number"))),
        stated("Non-uniformity of the light ΔE", text_of(light.get("nonuniformity_percent"), "%")),
        stated("Irradiance calibration accuracy", text_of(light.get("calibration_error_percent"), "%")),
        stated("Irradiance measurement error", text_of(emva.get("irradiance_measurement_error_percent"), "%")),
        stated("Control of the temperature", text_of(emva.get("temperature_control"))),
    )


def point_facts(results: Results, rows: Sequence[Row], iso: float | None) -> tuple[Fact, ...]:
    """Return the block on the left of a summary page."""
    emva, light = record(results, "emva"), record(results, "light")
    series = cast("Sequence[Record]", results.study.get("series") or ())
    mine = [one for one in series if one.get("iso") == iso]
    levels = record(results, "black_level").get("values")
    black = ", ".join(text_of(level) for level in levels) if isinstance(levels, Sequence) else ""
    internal = sorted({row.temperature_c for row in rows if row.temperature_c is not None})
    return (
        stated("Type of data", text_of(emva.get("data_type"))),
        stated("Exposure control", _CONTROL.get(str(light.get("control")), "")),
        stated("Exposure times", _exposures(mine)),
        *(stated(label, text_of(emva.get(key), unit)) for label, key, unit in _SETTINGS),
        stated("ISO", "" if iso is None else f"{iso:g}"),
        stated("Black level", f"{black} DN" if black else ""),
        *(stated(label, text_of(emva.get(key), unit)) for label, key, unit in _TEMPERATURES),
        stated("Internal temperature", ", ".join(f"{value:.1f} °C" for value in internal)),
        stated("Wavelength, centroid", text_of(light.get("wavelength_nm"), "nm")),
        stated("Wavelength, FWHM", text_of(light.get("fwhm_nm"), "nm")),
    )


def _exposures(series: Sequence[Record]) -> str:
    times = sorted({float(cast("float", one["exposure_s"])) for one in series if one.get("exposure_s")})
    if not times:
        return ""
    ends = [show_exposure(time) for time in (times[0], times[-1])]
    return ends[0] if len(times) == 1 else f"{ends[0]} to {ends[1]}"

"""What the numbers of a config ask of each other; each alone is checked by its table."""

from collections import Counter

from fullwell.errors import UsageError
from fullwell.raw.cfa import MONO, cell
from fullwell.simulate.pictures import SUFFIXES
from fullwell.simulate.scene import SUBJECTS
from fullwell.simulate.sensors import black_levels, white_level
from fullwell.simulate.tables import CameraTable, ChartTable, ConfigTable, FlatTable, StudyTable

_COMPRESSED = "dng"


def require_consistent(table: ConfigTable, name: str) -> None:
    """Refuse a config that contradicts itself.

    Raises
    ------
    UsageError
        With key, value and what is allowed.

    """
    for sentence in (
        _levels(table.camera),
        _size(table.camera),
        _isos(table),
        _study(table.study),
        _chart(table.chart),
        _physics(table.camera),
        _output(table),
    ):
        if sentence:
            raise UsageError(f"{name}: {sentence}")


def _levels(camera: CameraTable) -> str | None:
    """Return what is wrong with the levels, at any ISO."""
    said = [(f"camera.at_iso of ISO {one.iso}: ", one.black_level) for one in camera.at_iso]
    for where, black in (("", camera.black_level), *said):
        if black is not None and (wrong := _level(camera.model_copy(update={"black_level": black}))):
            return f"{where}{wrong}"
    return None


def _level(camera: CameraTable) -> str | None:
    most = 2**camera.bit_depth - 1
    white, black = white_level(camera), black_levels(camera)
    sites = cell(camera.cfa) ** 2
    if white > most:
        return f"camera.white_level = {white} does not fit {camera.bit_depth} bits; allowed: up to {most} DN."
    if max(black, default=0.0) >= white:
        return (
            f"camera.black_level = {camera.black_level} is not below camera.white_level = {white}; "
            f"allowed: from 0 to below {white} DN."
        )
    if len(black) != sites:
        many = "" if camera.cfa == MONO else f", or a list of {sites}"
        return (
            f"camera.black_level = {camera.black_level} has {len(black)} numbers; allowed for {camera.cfa}: "
            f"one number{many}."
        )
    return None


def _size(camera: CameraTable) -> str | None:
    for key, size in (("width", camera.width), ("height", camera.height)):
        if size % cell(camera.cfa):
            return f"camera.{key} = {size} is odd; allowed for {camera.cfa}: even numbers."
    return None


def _isos(table: ConfigTable) -> str | None:
    study, said = table.study, [one.iso for one in table.camera.at_iso]
    if len(set(study.isos)) != len(study.isos):
        return f"study.isos = {study.isos} names an ISO twice; allowed: each once."
    if len(set(said)) != len(said):
        return f"camera.at_iso names the ISOs {said}; allowed: each once."
    return None


def _study(study: StudyTable) -> str | None:
    if not (study.flat or study.dark or study.bias or study.chart or study.scene or study.series):
        return "[study] takes no frames; give it at least one of flat, dark, bias, chart, scene and series."
    for key, taken in (("flat", study.flat), ("chart", study.chart)):
        if taken and len(taken.exposures_s) != len(taken.electrons):
            return _unlike(key, taken)
    taken_of = [(series.kind, series.iso, series.exposure_s, series.temperature_c) for series in study.series]
    twice = next((key for key, count in Counter(taken_of).items() if count > 1), None)
    if twice:
        kind, iso, exposure_s, _ = twice
        return (
            f"study.series takes {kind} frames at ISO {iso} and {exposure_s:g} s twice; "
            "allowed: one series of a kind at an ISO and an exposure."
        )
    return _subjects(study)


def _unlike(key: str, taken: FlatTable) -> str:
    return (
        f"study.{key}.electrons = {taken.electrons} has {len(taken.electrons)} numbers; "
        f"allowed: one per exposure, {len(taken.exposures_s)}."
    )


def _subjects(study: StudyTable) -> str | None:
    named = [("study.scene.subjects holds", subject) for subject in (study.scene.subjects if study.scene else ())]
    named += [("study.series.subject =", series.subject) for series in study.series if series.subject]
    for where, subject in named:
        if subject not in SUBJECTS and not subject.lower().endswith(SUFFIXES):
            return f'{where} "{subject}"; allowed: {", ".join(sorted(SUBJECTS))}, or the path of a picture.'
    return None


def _chart(chart: ChartTable) -> str | None:
    if chart.patches and (chart.name or chart.densities):
        other = "name" if chart.name else "densities"
        return f"chart.patches and chart.{other} both say where patches are; allowed: one of them."
    for number, patch in enumerate(chart.patches):
        for key, value in (("x", patch.x), ("y", patch.y), ("width", patch.width), ("height", patch.height)):
            if value % 2:
                return f"chart.patches.{number}.{key} = {value} is odd; allowed: even numbers of pixels."
    return None


def _physics(camera: CameraTable) -> str | None:
    if camera.dark_current_spread and not camera.dark_current:
        return (
            f"camera.dark_current_spread = {camera.dark_current_spread:g} is the spread of a dark current of 0; "
            "allowed: a camera.dark_current above 0 with it."
        )
    matrix = camera.colour_matrix
    if matrix is not None and [len(row) for row in matrix] != [3, 3, 3]:
        return f"camera.colour_matrix = {matrix} is not square; allowed: three rows of three numbers."
    return None


def _output(table: ConfigTable) -> str | None:
    output = table.output
    for key, value in output.optical_black.model_dump().items():
        if value % cell(table.camera.cfa):
            return f"output.optical_black.{key} = {value} is odd; allowed for {table.camera.cfa}: even numbers."
    if output.companding_bits is not None and output.companding_bits >= table.camera.bit_depth:
        return (
            f"output.companding_bits = {output.companding_bits} is not below camera.bit_depth = "
            f"{table.camera.bit_depth}; allowed: from 4 to {table.camera.bit_depth - 1} bits."
        )
    for key in ("optical_black", "companding_bits", "noise_profile"):
        if output.format != _COMPRESSED and key in output.model_dump(exclude_defaults=True):
            return f'output.{key} does not go with format "{output.format}", which cannot tell of it; allowed: "dng".'
    if output.compression != "none" and output.format != _COMPRESSED:
        return (
            f'output.compression = "{output.compression}" does not go with format "{output.format}"; allowed: "none".'
        )
    return None

"""What the numbers of a config ask of each other; each alone is checked by its table."""

from collections import Counter

from fullwell.errors import UsageError
from fullwell.raw.cfa import MONO, cell
from fullwell.simulate.scene import SUBJECTS
from fullwell.simulate.sensors import black_levels, white_level
from fullwell.simulate.tables import CameraTable, ChartTable, ConfigTable, FlatTable, OutputTable, StudyTable

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
        _output(table.output),
    ):
        if sentence:
            raise UsageError(f"{name}: {sentence}")


def _levels(camera: CameraTable) -> str | None:
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
    taken_of = [(series.kind, series.iso, series.exposure_s) for series in study.series]
    twice = next((key for key, count in Counter(taken_of).items() if count > 1), None)
    if twice:
        kind, iso, exposure_s = twice
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
        if subject not in SUBJECTS:
            return f'{where} "{subject}"; allowed: {", ".join(sorted(SUBJECTS))}.'
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


def _output(output: OutputTable) -> str | None:
    if output.compression != "none" and output.format != _COMPRESSED:
        return (
            f'output.compression = "{output.compression}" does not go with format "{output.format}"; allowed: "none".'
        )
    return None

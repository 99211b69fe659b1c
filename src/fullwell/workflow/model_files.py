"""Noise models out of files: the results of a measurement, or the NoiseProfile of a raw file."""

from pathlib import Path

from fullwell.errors import RawFileError, UsageError
from fullwell.figures.measured_model import models_of_rows
from fullwell.figures.noise_model import Conventions, GivenModel
from fullwell.figures.results import Row
from fullwell.report.reading import read_results
from fullwell.workflow.model_figures import models_of_profile


def models_of_file(path: Path) -> tuple[GivenModel, ...]:
    """Return the noise models of results.json, of a folder with one, or of a raw file's NoiseProfile.

    Raises
    ------
    UsageError
        Where the file is none of them, or holds no noise model.

    """
    results = not path.is_file() or path.suffix.lower() == ".json"
    return _models_of_results(path) if results else _models_of_raw(path)


def _models_of_raw(path: Path) -> tuple[GivenModel, ...]:
    from fullwell.raw.open import read_header  # noqa: PLC0415 - results need no decoders

    try:
        header = read_header(path)
    except RawFileError as error:
        raise UsageError(f"{path}: {error.message}. Give results.json, or a DNG with a NoiseProfile.") from error
    if not header.noise_profile:
        raise UsageError(f"{path} has no NoiseProfile; measure the camera with `fullwell characterize`.")
    if header.white_level is None or header.black_level is None:
        raise UsageError(f"{path} does not say its white and black level; give --noise-profile, --white and --black.")
    white = max(header.white_level.values)
    conventions = Conventions(
        digital_maximum=white,
        white_level=white,
        black_level=sum(header.black_level.values) / len(header.black_level.values),
    )
    return models_of_profile(header.noise_profile, conventions, iso=header.iso)


def _models_of_results(path: Path) -> tuple[GivenModel, ...]:
    models = models_of_rows(_of_whole_plane(path))
    if not models:
        raise UsageError(f"{path} holds no noise model: it takes flats of several exposures, or a chart, to fit one.")
    return models


def _of_whole_plane(path: Path) -> list[Row]:
    """Return the rows of the whole plane."""
    return [row for row in read_results(path).rows if row.region is None and row.exposure_s is None]

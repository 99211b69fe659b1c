"""The tables of the published Pixel study, under its own names (RESULTS 4).

Tables of one ISO are written as soon as they are known (`write_iso_tables`), so that no more than one ISO's maps need
be in memory; what spans the study follows at the end (`write_study_tables`). Numbers are the shortest text that reads
back as the same number; those of single pixels have twelve digits.
"""

from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.fit.legacy.dark import StudyDarkLine
from fullwell.fit.legacy.read_noise import ReadNoiseRepeats
from fullwell.fit.legacy.response import ChannelResponse, StudyResponse
from fullwell.fit.legacy.shading_map import Poly22
from fullwell.fit.legacy.volts import VoltScale
from fullwell.kernels.decimal_text import LONGEST, put_lines
from fullwell.raw.cfa import ALL, MONO, channel_rank

COEFFICIENTS: Final = "shading_coefficients.csv"
READ_NOISE: Final = "read_noise.csv"
DARK_CURRENT: Final = "dark_current.csv"
README: Final = "README.txt"

_BLOCK: Final = 1 << 16
"""Numbers that become text at once."""
_SUFFIXES: Final = {ALL: "all_px", MONO: "all_px", "R": "r", "G": "g", "B": "b"}


@dataclass(frozen=True, slots=True, kw_only=True)
class ShadingCoefficients:
    """The quadratic surface of one plane of one burst of flats.

    Parameters
    ----------
    iso
        None where nothing says it.
    exposure_s
        [s].
    channel
        ``R``, ``G1``, ``G2``, ``B`` or ``mono``.

    """

    iso: float | None
    exposure_s: float
    channel: str
    surface: Poly22


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyTables:
    """What the study's tables say beyond a single ISO.

    Parameters
    ----------
    coefficients
        Every burst of flats of every ISO.
    read_noise, dark_lines
        Per ISO; empty without bias or dark frames.
    volts
        None where the voltage swing is unknown: cells in V stay empty.
    base_iso, base_exposure_s
        The burst whose map all flats are divided by; the exposure is None where there are no flats [s].
    scaled
        Whether crop and tiles are scaled down to the size of the frames.
    black_subtracted
        Whether the black level was subtracted first, which the published study did not do.

    """

    coefficients: tuple[ShadingCoefficients, ...] = ()
    read_noise: tuple[ReadNoiseRepeats, ...] = ()
    dark_lines: tuple[StudyDarkLine, ...] = ()
    volts: VoltScale | None = None
    base_iso: float | None = None
    base_exposure_s: float | None = None
    scaled: bool = False
    black_subtracted: bool = False


def iso_folder(iso: float | None) -> str:
    """Return the name of the folder that holds the tables of one ISO.

    Examples
    --------
    >>> iso_folder(55.0), iso_folder(None)
    ('iso_55', 'iso_unknown')

    """
    return f"iso_{_number(iso) or 'unknown'}"


def write_iso_tables(response: StudyResponse, folder: Path, *, workers: int = 1) -> None:
    """Write the tables of one ISO into its folder.

    Parameters
    ----------
    response
        Everything that the study derives from the flats of that ISO.
    folder
        The ``tables`` folder; the ISO's own is made in it.
    workers
        Threads.

    """
    own = folder / iso_folder(response.iso)
    own.mkdir(parents=True, exist_ok=True)
    tables = dict(_maps(response.crop, prefix=""))
    for number, tile in enumerate(response.tiles, start=1):
        tables |= _maps(tile, prefix=f"patch_{number}")
    tables |= _spreads(response)
    with ThreadPoolExecutor(max(1, workers)) as pool:
        for done in [pool.submit(write_matrix, own / name, values) for name, values in tables.items()]:
            done.result()


def write_study_tables(tables: StudyTables, folder: Path) -> None:
    """Write what spans the study, and what each file is, into the ``tables`` folder; empty tables are left out."""
    folder.mkdir(parents=True, exist_ok=True)
    content = {
        COEFFICIENTS: (_COEFFICIENT_COLUMNS, _coefficient_rows(tables.coefficients)),
        READ_NOISE: (_READ_NOISE_COLUMNS, _read_noise_rows(tables.read_noise, tables.volts)),
        DARK_CURRENT: (_DARK_COLUMNS, _dark_rows(tables.dark_lines, tables.volts)),
    }
    for name, (columns, rows) in content.items():
        lines = [",".join(row) for row in rows]
        if lines:
            _write_text(folder / name, [",".join(columns), *lines])
    _write_text(folder / README, _readme(tables))


def write_matrix(path: Path, values: NDArray[np.float64]) -> None:
    """Write a matrix without a header, one line per row, shape (V, H), to twelve significant digits."""
    height = max(1, _BLOCK // values.shape[1])
    text = np.empty(LONGEST * height * values.shape[1], np.uint8)
    with path.open("wb") as file:
        for top in range(0, values.shape[0], height):
            file.write(text[: put_lines(np.ascontiguousarray(values[top : top + height]), text)].data)


def _maps(responses: Sequence[ChannelResponse], *, prefix: str) -> Mapping[str, NDArray[np.float64]]:
    tables: dict[str, NDArray[np.float64]] = {}
    for one in responses:
        suffix = _SUFFIXES[one.channel]
        tables[f"{prefix}px_resp_{suffix}.csv"] = one.slope_dn_per_s
        tables[f"{prefix}darkv_{suffix}.csv"] = one.intercept_dn
    return tables


def _spreads(response: StudyResponse) -> Mapping[str, NDArray[np.float64]]:
    crop, tiles = response.crop_spread, response.tile_spread
    return {
        "PRNU_final_cropped_image.csv": np.concatenate([crop.slope_std, crop.slope_mean]).T,
        "DSNU_final_cropped_image.csv": np.concatenate([crop.intercept_std, crop.intercept_mean]).T,
        "PRNU_1288_cropped_image.csv": crop.prnu_percent.T,
        "PRNU_final_16patches.csv": tiles.slope_std,
        "DSNU_final_16patches.csv": tiles.intercept_std,
        "DarkV_final_patches.csv": tiles.intercept_mean,
        "PRNU1288_patches.csv": tiles.prnu_percent,
        "PX_Response_final_patches.csv": tiles.slope_mean,
    }


_COEFFICIENT_COLUMNS: Final = ("iso", "exposure_s", "channel", "p00", "p10", "p01", "p20", "p11", "p02")
_READ_NOISE_COLUMNS: Final = ("iso", "repeat", "flow1_dn", "flow2_dn", "flow2_v")
_DARK_COLUMNS: Final = ("iso", "channel", "slope_dn_per_s", "intercept_dn", "slope_v_per_s")


def _coefficient_rows(coefficients: Iterable[ShadingCoefficients]) -> Iterable[tuple[str, ...]]:
    for one in sorted(coefficients, key=lambda row: (row.iso or 0.0, row.exposure_s, channel_rank(row.channel))):
        terms = (_number(value) for value in one.surface.coefficients)
        yield (_number(one.iso), _number(one.exposure_s), one.channel, *terms)


def _read_noise_rows(bursts: Iterable[ReadNoiseRepeats], volts: VoltScale | None) -> Iterable[tuple[str, ...]]:
    for burst in bursts:
        for index in range(len(burst.frames)):
            flow1, flow2 = float(burst.flow1_dn[index]), float(burst.flow2_dn[index])
            flow2_v = None if volts is None else volts.read_noise_v(flow2)
            yield (_number(burst.iso), str(index + 1), _number(flow1), _number(flow2), _number(flow2_v))


def _dark_rows(lines: Iterable[StudyDarkLine], volts: VoltScale | None) -> Iterable[tuple[str, ...]]:
    for line in lines:
        slope_v = None if volts is None else volts.level_v(line.slope_dn_per_s)
        numbers = (line.slope_dn_per_s, line.intercept_dn, slope_v)
        yield (_number(line.iso), line.channel, *(_number(value) for value in numbers))


def _number(value: float | None) -> str:
    """Return the shortest text that reads back as the same number; empty for None."""
    if value is None:
        return ""
    return str(int(value)) if value == round(value) and abs(value) < 2**53 else repr(float(value))


def _write_text(path: Path, lines: Sequence[str]) -> None:
    path.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")


def _readme(tables: StudyTables) -> list[str]:
    lines = [
        "Tables of the published Pixel 4a study, computed by its own formulas from the frames of this study.",
        "They are here so that the published numbers can be checked. They keep the study's flaws: temporal noise",
        "counts as non-uniformity, green is the mean of two greens. The corrected figures are in results.json.",
        "",
    ]
    if tables.base_exposure_s is not None:
        lines += _flats_readme(tables)
    if tables.read_noise:
        lines += [
            f"{READ_NOISE}: per ISO and repeat (first five frames by name, whole mosaic, quantization left in).",
            "  flow1_dn: root mean square over the pairs with this frame of std(difference) / sqrt(2) [DN]",
            "  flow2_dn: std of burst mean less frame [DN]",
            "  flow2_v: flow2_dn * (voltage swing rounded to 4 decimals) / 2^bits [V]",
            "",
        ]
    if tables.dark_lines:
        lines += [
            f"{DARK_CURRENT}: line through frame means of dark frames against exposure; at the lowest ISO all frames,",
            "  at the others the first by name of each exposure. G is the mean of both greens.",
            "  slope_dn_per_s [DN/s], intercept_dn [DN]",
            "  slope_v_per_s: slope * (voltage swing rounded to 3 decimals) / white level [V/s]",
            "",
        ]
    if tables.volts is None and (tables.read_noise or tables.dark_lines):
        lines += ["Cells in V are empty: the voltage swing is unknown (give --camera, or voltage_swing_v).", ""]
    return lines[:-1]


def _flats_readme(tables: StudyTables) -> list[str]:
    burst = f"ISO {_number(tables.base_iso) or 'unknown'}, {_number(tables.base_exposure_s)} s"
    pedestal = "subtracted first (not as published)" if tables.black_subtracted else "left in, as published"
    where = "scaled down to the size of these frames" if tables.scaled else "as published"
    return [
        f"{COEFFICIENTS}: p00 + p10 x + p01 y + p20 x^2 + p11 x y + p02 y^2 [DN], fitted to the mean of",
        "  each burst of flats and plane; x = row and y = column of the plane, counted from 1.",
        "",
        f"iso_<n>/: flats divided by one map, that of {burst} (each plane's surface over its maximum). Pedestal",
        f"  {pedestal}. Crop imcrop [917 1505 1317 967] and 16 tiles, {where}.",
        "  No header. Columns and rows in the order all, r, g, b; g = (G1 + G2) / 2. A mono sensor has one.",
        "  px_resp_*.csv: slope of each pixel against exposure, over the crop [DN/s]",
        "  darkv_*.csv: its intercept [DN]",
        "  patch_<k>px_resp_*.csv, patch_<k>darkv_*.csv: the same in tile k, 1 to 16",
        "  PRNU_final_cropped_image.csv: per channel standard deviation and mean of the slopes of the crop [DN/s]",
        "  DSNU_final_cropped_image.csv: per channel standard deviation and mean of the intercepts [DN]",
        "  PRNU_1288_cropped_image.csv: 100 * standard deviation / mean of the slopes [%]",
        "  PRNU_final_16patches.csv, PX_Response_final_patches.csv: standard deviation, mean of the slopes by tile",
        "  DSNU_final_16patches.csv, DarkV_final_patches.csv: standard deviation, mean of the intercepts by tile",
        "  PRNU1288_patches.csv: 100 * standard deviation / mean of the slopes by tile [%]",
        "",
    ]

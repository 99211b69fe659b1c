"""The published study's tables against its own formulas in GNU Octave, on the same files."""

import shutil
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from independent_study import write_dng
from pyarrow import csv

from fullwell.fit.legacy.dark import DarkFrames, study_dark_lines
from fullwell.fit.legacy.regions import study_regions
from fullwell.fit.legacy.response import LegacyFigure, response_figures, study_response
from fullwell.fit.legacy.shading_map import fit_legacy_map
from fullwell.fit.legacy.std_line import StdLine
from fullwell.fit.legacy.volts import VoltScale
from fullwell.frames.selection import Selection
from fullwell.frames.series import Kind
from fullwell.frames.study import load_study
from fullwell.report.study_tables import ShadingCoefficients, StudyTables, write_iso_tables, write_study_tables
from fullwell.workflow.duplicates import reduce_without_copies
from fullwell.workflow.measure.bursts import Burst, group_by_iso
from fullwell.workflow.published.second_look import look_again

SCRIPT = Path(__file__).with_name("published_study.m")
VOLTS = VoltScale(swing_v=0.45907, bit_depth=10, white_level=1023.0)
BLACK, WHITE = 64, 1023
CHANNELS = ("R", "G1", "G2", "B")
SITES = {"B": (0, 0), "G1": (1, 0), "G2": (0, 1), "R": (1, 1)}
"""BGGR by the project's names: G1 is the green of the red rows."""
RESPONSE = {"R": 0.55, "G1": 1.0, "G2": 0.98, "B": 0.65}
TOLERANCE = 1e-9
"""RESULTS 4."""

Tables = dict[str, np.ndarray]


@dataclass(frozen=True, kw_only=True)
class Plan:
    """How much of a study to make; exposures in microseconds."""

    height: int
    width: int
    isos: tuple[int, ...]
    flat_us: tuple[int, ...]
    flats: int
    dark_us: tuple[int, ...]
    darks: int
    biases: int = 5

    @property
    def captures(self) -> list[tuple[str, int, int, int]]:
        """Folder, ISO, exposure and frame number of every file, in the order Octave reads them."""
        kinds = (
            ("PRNU_DSNU", self.flat_us, self.flats),
            ("DarkCurrentRate", self.dark_us, self.darks),
            ("ReadNoise", (100,), self.biases),
        )
        return [
            (kind, iso, exposure, number)
            for kind, exposures, count in kinds
            for iso in self.isos
            for exposure in exposures
            for number in range(count)
        ]


SMALL = Plan(
    height=560,
    width=700,
    isos=(55, 99),
    flat_us=(1000, 2000, 3000, 4000, 5000),
    flats=4,
    dark_us=(10000, 20000, 40000, 160000),
    darks=2,
    biases=6,
)
LARGE = Plan(height=2480, width=2240, isos=(55,), flat_us=(1000, 2500, 5000), flats=2, dark_us=(10000, 160000), darks=1)


class Sensor:
    """Signal in proportion to exposure behind a lens that darkens the corners, with fixed patterns."""

    def __init__(self, plan: Plan, seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        shape = (plan.height, plan.width)
        self.shape = shape
        y, x = np.mgrid[: plan.height, : plan.width]
        radius2 = (x / plan.width - 0.52) ** 2 + (y / plan.height - 0.47) ** 2
        light = 1.0 / (1.0 + 0.9 * radius2) ** 2 * (1.0 + self.rng.normal(0.0, 0.007, shape))
        for channel, (row, column) in SITES.items():
            light[row::2, column::2] *= RESPONSE[channel]
        self.light = light
        self.offset = BLACK + self.rng.normal(0.0, 0.4, shape)

    def frame(self, *, iso: int, exposure_us: int, lit: bool) -> np.ndarray:
        signal = 0.16 * exposure_us * self.light if lit else np.full(self.shape, 2e-5 * exposure_us)
        noise = np.sqrt(1.5**2 + 0.17 * iso / 55 * signal) * self.rng.standard_normal(self.shape)
        return np.clip(np.rint(self.offset + signal + noise), 0, WHITE).astype(np.uint16)


def write_study(plan: Plan, root: Path, *, seed: int) -> None:
    """Write the study as DNG files, and the same codes as one binary file with Octave's instructions."""
    sensor = Sensor(plan, seed)
    job = root / "job"
    job.mkdir(parents=True)
    with (job / "frames.bin").open("wb") as binary:
        for kind, iso, exposure, number in plan.captures:
            mosaic = sensor.frame(iso=iso, exposure_us=exposure, lit=kind == "PRNU_DSNU")
            path = root / "study" / kind / f"ISO_{iso}" / f"IMG_{exposure:08d}_{number}.dng"
            write_dng(path, mosaic, iso=iso, exposure_s=exposure / 1e6, black=BLACK, white=WHITE)
            binary.write(mosaic.astype("<u2").tobytes())
    at = ", ".join(f"'{name}', [{row + 1} {column + 1}]" for name, (row, column) in SITES.items())
    lines = [
        f"rows = {plan.height}; columns = {plan.width}; at = struct({at});",
        f"isos = {list(plan.isos)}; flat_exposures = {list(plan.flat_us)} ./ 1e6; flat_frames = {plan.flats};",
        f"dark_exposures = {list(plan.dark_us)} ./ 1e6; dark_frames = {plan.darks}; bias_frames = {plan.biases};",
    ]
    (job / "job.m").write_text("\n".join(lines) + "\n")


def run_octave(job: Path) -> Tables:
    command = ["octave", "--no-gui", "--norc", "--quiet", str(SCRIPT), str(job)]
    done = subprocess.run(command, check=False, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    values = np.fromfile(job / "tables.bin", "<f8")
    tables, at = Tables(), 0
    for line in (job / "tables.txt").read_text().splitlines():
        name, rows, columns = line.split()
        shape = (int(rows), int(columns))
        tables[name] = values[at : at + shape[0] * shape[1]].reshape(shape)
        at += shape[0] * shape[1]
    assert at == values.size
    return tables


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What is not in a table."""

    figures: dict[int, tuple[LegacyFigure, ...]]
    std_line: StdLine


def run_fullwell(study: Path, folder: Path) -> Outcome:
    """Reduce the files, apply the published formulas to the sums, and write the tables."""
    indexed = load_study(study, Selection())
    reduction = reduce_without_copies(indexed, workers=2, tile=32, keep=(Kind.FLAT,))
    groups = group_by_iso(indexed, reduction.statistics, reduction.sums)
    lowest = groups[0]
    base = fit_legacy_map(lowest.flats[0].sums, lowest.flats[0].frames, cfa=indexed.cfa)
    regions = study_regions(indexed.height, indexed.width)
    figures, coefficients, dark_lines = {}, [], []
    for group in groups:
        bursts = group.flats
        response = study_response(
            [burst.sums for burst in bursts],
            [burst.frames for burst in bursts],
            [burst.exposure_s for burst in bursts],
            iso=group.iso,
            cfa=indexed.cfa,
            base=base,
            regions=regions,
        )
        write_iso_tables(response, folder, workers=2)
        figures[int(group.iso)] = response_figures(response)
        for burst in bursts:
            fitted = fit_legacy_map(burst.sums, burst.frames, cfa=indexed.cfa)
            surfaces = dict(zip(group.channels, fitted.surfaces, strict=True))
            coefficients += [
                ShadingCoefficients(
                    iso=group.iso, exposure_s=burst.exposure_s, channel=channel, surface=surfaces[channel]
                )
                for channel in CHANNELS
            ]
        dark_lines += study_dark_lines(
            [dark_frames(burst) for burst in group.darks], iso=group.iso, cfa=indexed.cfa, every_frame=group is lowest
        )
    look = look_again(groups, base=base, workers=2)
    assert not look.findings
    tables = StudyTables(
        coefficients=tuple(coefficients), read_noise=look.read_noise, dark_lines=tuple(dark_lines), volts=VOLTS
    )
    write_study_tables(tables, folder)
    return Outcome(figures=figures, std_line=look.std_line)


def dark_frames(burst: Burst) -> DarkFrames:
    planes = burst.statistics.planes
    return DarkFrames(
        exposures_s=np.full(burst.frames, burst.exposure_s),
        frame_means_dn=np.stack([plane.frame_means for plane in planes], axis=1),
        pixels=np.array([plane.n for plane in planes]),
    )


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """One study by both."""

    plan: Plan
    octave: Tables
    folder: Path
    published: Outcome

    def matrix(self, name: str) -> np.ndarray:
        options = csv.ReadOptions(autogenerate_column_names=True, block_size=1 << 28)
        return np.stack(
            [column.to_numpy() for column in csv.read_csv(self.folder / name, read_options=options).columns], axis=1
        )

    def rows(self, name: str) -> tuple[list[str], list[list[str]]]:
        header, *lines = [line.split(",") for line in (self.folder / name).read_text().splitlines()]
        return header, lines


def compare(plan: Plan, root: Path, *, seed: int) -> Comparison:
    if shutil.which("octave") is None:
        pytest.skip("needs GNU Octave (Debian package octave) for an independent run of the study's formulas")
    write_study(plan, root, seed=seed)
    published = run_fullwell(root / "study", root / "tables")
    return Comparison(plan=plan, octave=run_octave(root / "job"), folder=root / "tables", published=published)


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Comparison:
    return compare(SMALL, tmp_path_factory.mktemp("small"), seed=4)


@pytest.fixture(scope="module")
def large(tmp_path_factory: pytest.TempPathFactory) -> Comparison:
    return compare(LARGE, tmp_path_factory.mktemp("large"), seed=5)


@pytest.fixture(params=["small", "large"])
def both(request: pytest.FixtureRequest) -> Comparison:
    return request.getfixturevalue(request.param)


def files_of_one_iso() -> set[str]:
    """RESULTS 4, spelled out."""
    maps = {f"{kind}_{channel}.csv" for kind in ("px_resp", "darkv") for channel in ("all_px", "r", "g", "b")}
    return {
        *maps,
        *(f"patch_{number}{name}" for number in range(1, 17) for name in maps),
        "PRNU_final_cropped_image.csv",
        "DSNU_final_cropped_image.csv",
        "PRNU_final_16patches.csv",
        "DSNU_final_16patches.csv",
        "DarkV_final_patches.csv",
        "PRNU1288_patches.csv",
        "PRNU_1288_cropped_image.csv",
        "PX_Response_final_patches.csv",
    }


def test_the_folder_holds_the_published_names(both: Comparison) -> None:
    found = {str(path.relative_to(both.folder)) for path in both.folder.rglob("*") if path.is_file()}
    whole = {"README.txt", "shading_coefficients.csv", "read_noise.csv", "dark_current.csv"}
    assert found == whole | {f"iso_{iso}/{name}" for iso in both.plan.isos for name in files_of_one_iso()}


def test_every_table_of_an_iso_is_octaves(both: Comparison) -> None:
    expected = {name: values for name, values in both.octave.items() if name.startswith("iso_")}
    assert len(expected) == len(both.plan.isos) * len(files_of_one_iso())
    off = {
        name: float(np.abs(ours / values - 1.0).max())
        for name, values in expected.items()
        if (ours := both.matrix(name)).shape != values.shape or not np.allclose(ours, values, rtol=TOLERANCE, atol=0.0)
    }
    assert not off


def test_the_crop_is_scaled_only_where_it_does_not_fit(small: Comparison, large: Comparison) -> None:
    assert large.octave["iso_55/px_resp_all_px.csv"].shape == (968, 1318)
    assert large.octave["iso_55/patch_16darkv_g.csv"].shape == (32, 32)
    flags = [{figure.flags for figure in one.published.figures[55]} for one in (small, large)]
    assert flags == [{("scaled-crop",)}, {()}]


def test_shading_coefficients_are_octaves(both: Comparison) -> None:
    header, lines = both.rows("shading_coefficients.csv")
    assert header == ["iso", "exposure_s", "channel", "p00", "p10", "p01", "p20", "p11", "p02"]
    ours = np.array([[*line[:2], CHANNELS.index(line[2]) + 1, *line[3:]] for line in lines], float)
    expected = both.octave["shading_coefficients.csv"]
    assert ours[:, :3].tolist() == expected[:, :3].tolist()
    np.testing.assert_allclose(ours[:, 3:], expected[:, 3:], rtol=TOLERANCE)


def test_read_noise_is_octaves(both: Comparison) -> None:
    header, lines = both.rows("read_noise.csv")
    assert header == ["iso", "repeat", "flow1_dn", "flow2_dn", "flow2_v"]
    np.testing.assert_allclose(np.array(lines, float), both.octave["read_noise.csv"], rtol=TOLERANCE)


def test_dark_current_is_octaves(both: Comparison) -> None:
    header, lines = both.rows("dark_current.csv")
    assert header == ["iso", "channel", "slope_dn_per_s", "intercept_dn", "slope_v_per_s"]
    channels = ("all", "R", "G", "B")
    ours = np.array([[line[0], channels.index(line[1]) + 1, *line[2:]] for line in lines], float)
    np.testing.assert_allclose(ours, both.octave["dark_current.csv"], rtol=TOLERANCE)


def test_std_against_exposure_is_octaves(both: Comparison) -> None:
    line = both.published.std_line
    published_v = VOLTS.level_v(line.as_published)
    ours = [line.slope_dn_per_s / 65535.0, line.as_published, published_v]
    np.testing.assert_allclose([ours], both.octave["std_line"], rtol=TOLERANCE)
    np.testing.assert_allclose(line.std_dn / 65535.0, both.octave["std_of_frames"][:, 0], rtol=TOLERANCE)


@pytest.mark.parametrize(
    ("quantity", "over_crop", "over_tiles"),
    [
        ("prnu", lambda table: table["PRNU_1288_cropped_image.csv"][:, 0], "PRNU1288_patches.csv"),
        ("dsnu", lambda table: table["DSNU_final_cropped_image.csv"][:, 0], "DSNU_final_16patches.csv"),
    ],
)
def test_figures_are_those_of_the_tables(
    both: Comparison, quantity: str, over_crop: Callable[[Tables], np.ndarray], over_tiles: str
) -> None:
    for iso, every in both.published.figures.items():
        own = {name.split("/")[1]: table for name, table in both.octave.items() if name.startswith(f"iso_{iso}/")}
        figures = [figure for figure in every if figure.quantity == quantity]
        crop = [figure.value for figure in figures if figure.region is not None]
        tiles = [figure.value for figure in figures if figure.region is None]
        np.testing.assert_allclose(crop, over_crop(own), rtol=TOLERANCE)
        np.testing.assert_allclose(tiles, np.median(own[over_tiles], axis=0), rtol=TOLERANCE)


def test_the_command_line_writes_the_same_tables(
    small: Comparison, characterize: Callable[..., tuple[int, dict]], tmp_path: Path
) -> None:
    status, _ = characterize(small.folder.parent / "study", tmp_path / "out", "--camera", "pixel-4a")
    assert status == 0
    written = tmp_path / "out" / "tables"
    names = {str(path.relative_to(small.folder)) for path in small.folder.rglob("*.csv")}
    assert {str(path.relative_to(written)) for path in written.rglob("*.csv")} == names
    assert [name for name in sorted(names) if (written / name).read_bytes() != (small.folder / name).read_bytes()] == []

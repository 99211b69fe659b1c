"""Charts: those that come with Fullwell, and one's own."""

from pathlib import Path

import numpy as np
import pytest

from fullwell.errors import UsageError
from fullwell.frames.chart.definition import chart_named, chart_names

NEUTRALS = {
    "white": 0.05, "neutral 8": 0.23, "neutral 6.5": 0.44, "neutral 5": 0.70, "neutral 3.5": 1.05, "black": 1.50
}  # fmt: skip
MINE = """
title = "Mine"
aspect = 2.0
densities = [0.1, 0.2, nan, 0.4, 0.5, 0.6]
srgb = [[250, 250, 250], [200, 200, 200], [10, 200, 10], [90, 90, 90], [60, 60, 60], [30, 30, 30]]
[grid]
rows = 2
columns = 3
fill = [0.5, 1.0]
"""


@pytest.mark.parametrize("name", ["colorchecker-classic", "colorchecker-passport"])
def test_only_the_neutral_patches_of_a_colorchecker_have_densities(name: str) -> None:
    chart = chart_named(name)
    assert len(chart.patches) == 24
    assert {one.name: one.density for one in chart.patches if one.density is not None} == NEUTRALS


def test_densities_agree_with_the_published_colours_of_the_neutrals() -> None:
    # The sRGB of the chart is published to a code: 1/52 of gamma 2.2 on the black patch, 0.02 density; 0.02 more
    # because the densities are published to 0.01 for other batches.
    for one in chart_named("colorchecker-classic").patches[18:]:
        assert one.density is not None
        assert -np.log10(one.rgb[1]) == pytest.approx(one.density, abs=0.04)


def test_a_step_wedge_has_41_steps_of_a_tenth() -> None:
    chart = chart_named("stouffer-t4110")
    assert [one.density for one in chart.patches] == [round(0.05 + 0.1 * step, 2) for step in range(41)]
    assert chart.in_line
    assert chart.transmissive


@pytest.mark.parametrize("name", chart_names())
def test_patches_lie_within_the_corners_and_apart(name: str) -> None:
    chart = chart_named(name)
    assert chart.name == name
    half = chart.sizes / 2
    assert np.all(chart.centres - half > -1e-9)
    assert np.all(chart.centres + half < 1 + 1e-9)
    apart = np.abs(chart.centres[:, None] - chart.centres[None, :])
    touching = np.all(apart < chart.sizes[:, None] * (1 - 1e-9), axis=2)
    assert np.array_equal(touching, np.eye(len(chart.patches), dtype=bool))
    assert "nominal" in chart.note.lower() or "published" in chart.note


def test_reads_a_chart_of_ones_own(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(MINE, encoding="utf-8")
    chart = chart_named(str(path))
    assert (chart.name, chart.title, chart.aspect) == ("mine", "Mine", 2.0)
    assert [one.density for one in chart.patches] == [0.1, 0.2, None, 0.4, 0.5, 0.6]
    # Three half-filled columns span 2.5 spacings: 0.2, 0.4 apart.
    np.testing.assert_allclose(chart.centres[:3, 0], [0.1, 0.5, 0.9])
    np.testing.assert_allclose(chart.sizes[0], [0.2, 0.5])


def test_reads_patches_one_by_one(tmp_path: Path) -> None:
    path = tmp_path / "single.toml"
    table = '[[patch]]\nname = "p{0}"\nx = 0.{0}\ny = 0.5\nwidth = 0.05\nheight = 0.2\n'
    text = 'title = "Five"\nfirst_density = 0.2\ndensity_step = 0.3\n' + "".join(map(table.format, range(1, 6)))
    path.write_text(text, encoding="utf-8")
    chart = chart_named(str(path))
    assert [(one.name, one.x, one.density) for one in chart.patches[:2]] == [("p1", 0.1, 0.2), ("p2", 0.2, 0.5)]


def test_reads_a_ring_and_a_grid_with_gaps(tmp_path: Path) -> None:
    steps = 'title = "R"\nfirst_density = 0.0\ndensity_step = 0.1\n'
    path = tmp_path / "ring.toml"
    path.write_text(steps + "[ring]\ncount = 8\nradius = 0.4\npatch = 0.1\n", encoding="utf-8")
    np.testing.assert_allclose(chart_named(str(path)).centres[[0, 2, 4]], [(0.5, 0.1), (0.9, 0.5), (0.5, 0.9)])
    path.write_text(steps + '[grid]\nrows = 2\ncolumns = 4\nlayout = ["xx.x", "x.xx"]\n', encoding="utf-8")
    np.testing.assert_allclose(chart_named(str(path)).centres[:, 0], [0.125, 0.375, 0.875, 0.125, 0.625, 0.875])


def test_measured_densities_extend_a_chart(tmp_path: Path) -> None:
    path = tmp_path / "film.toml"
    measured = [round(0.133 + 0.2486 * step, 4) for step in range(36)]
    path.write_text(f'title = "Film"\nextends = "dynamic-range-36-ring"\ndensities = {measured}\n', encoding="utf-8")
    chart, base = chart_named(str(path)), chart_named("dynamic-range-36-ring")
    assert [one.density for one in chart.patches] == measured
    np.testing.assert_array_equal(chart.centres, base.centres)
    assert chart.patches[3].rgb[0] == pytest.approx(10 ** -measured[3])


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (("rows = 2", "rows = 0"), "grid.rows"),
        (("rows = 2", "rows = 2\nturn = 1"), "grid.turn"),
        (("rows = 2", 'layout = ["xx", "xxx"]\nrows = 2'), "a character for every column"),
        (("[0.1, 0.2, nan", "[nan"), "densities has 4 entries for 6 patches"),
        (("0.1, 0.2", "-0.1, 0.2"), "densities are 0 or more"),
        (("srgb =", "# srgb ="), "density of every patch, or srgb"),
        (("[grid]\nrows = 2\ncolumns = 3\nfill = [0.5, 1.0]", ""), "either"),
        (("columns = 3", "columns = 1"), "at least 5 patches"),
        (("aspect = 2.0", 'names = ["a", "a", "b", "c", "d", "e"]'), "same name"),
        (("aspect = 2.0", 'extends = "colorchecker-classic"'), "grid, srgb cannot stand beside extends"),
        (("aspect = 2.0", 'extends = "q13"'), "is no chart"),
        (("aspect = 2.0", "aspect 2.0"), "not valid TOML"),
    ],
)
def test_refuses_what_is_not_a_chart(tmp_path: Path, change: tuple[str, str], sentence: str) -> None:
    path = tmp_path / "wrong.toml"
    path.write_text(MINE.replace(*change), encoding="utf-8")
    with pytest.raises(UsageError, match=r"wrong\.toml") as refused:
        chart_named(str(path))
    assert sentence in str(refused.value)


def test_names_the_charts_it_knows() -> None:
    with pytest.raises(UsageError, match="stouffer-t4110"):
        chart_named("q13")
    with pytest.raises(UsageError, match="Cannot read"):
        chart_named("none.toml")

"""What the pixels of one file tell: no alarm over simulated frames, the right one over changed ones."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fullwell.findings import Severity
from fullwell.raw.image import Area, Levels, RawHeader
from fullwell.raw.open import decode, read_header
from fullwell.raw.segments import Layout
from fullwell.testing.studies import simulated_study, simulation
from fullwell.workflow.inspection import inspect_file
from fullwell.workflow.signs.content import Content, look_at


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    camera = {"width": 640, "height": 480}
    folder = tmp_path_factory.mktemp("signs") / "study"
    simulated_study(folder, simulation(camera=camera))
    return folder


def frame(study: Path, kind: str) -> Path:
    return min(path for path in study.rglob("*.dng") if kind in path.as_posix().lower())


def seen(study: Path, kind: str, change: object = None, **declared: object) -> Content:
    """Look at a frame after a change of its mosaic, with other declarations."""
    header = read_header(frame(study, kind))
    data = header.path.read_bytes()
    mosaic = decode(header, data)
    changed = mosaic if change is None else np.clip(np.round(change(mosaic.astype(np.float64))), 0, 65535)  # type: ignore[operator]
    return look_at(replace(header, **declared), data, changed.astype(np.uint16))  # type: ignore[arg-type]


def codes(content: Content) -> set[str]:
    return {finding.code for finding in content.findings}


def test_simulated_frames_raise_no_alarm(study: Path) -> None:
    paths = sorted(study.rglob("*.dng"))
    found = [finding for path in paths for finding in inspect_file(path).findings]
    assert [finding for finding in found if finding.severity is not Severity.INFO] == []
    assert len(paths) > 20


def test_blacks_cut_off(study: Path) -> None:
    cut = seen(study, "bias", lambda x: np.maximum(x, 256.0))
    assert "black-clipped" in codes(cut)
    assert "black-clipped" in codes(seen(study, "dark", lambda x: x - 256.0))


def test_left_shifted_codes(study: Path) -> None:
    shifted = seen(study, "flat", lambda x: 16.0 * x, bit_depth=16)
    assert shifted.effective_bits == 12
    assert "code-step" in codes(shifted)


def test_bits_beyond_the_white_level_are_not_used(study: Path) -> None:
    white = read_header(frame(study, "flat")).white_level
    assert white is not None
    assert seen(study, "flat", bit_depth=16).effective_bits == int(max(white.values)).bit_length() < 16


def test_codes_of_a_linearization_table_are_not_above_the_bit_depth(study: Path) -> None:
    header = read_header(frame(study, "flat"))
    assert isinstance(header.layout, Layout)
    companded = replace(header.layout, table=tuple(range(0, 1024, 4)))
    found = seen(study, "flat", lambda x: 4.0 * (x // 4), bit_depth=8, layout=companded)
    assert "codes-above-bit-depth" not in codes(found)
    assert "code-step" in codes(found)
    assert found.effective_bits == 8
    assert "codes-above-bit-depth" in codes(seen(study, "flat", bit_depth=8))


def test_red_and_blue_multiplied(study: Path) -> None:
    def balanced(x: np.ndarray) -> np.ndarray:
        x[0::2, 0::2] = 1.7 * x[0::2, 0::2]  # B of BGGR
        x[1::2, 1::2] = 1.3 * x[1::2, 1::2]
        return x

    found = seen(study, "flat", balanced)
    assert [use.scale for use in found.uses] == [pytest.approx(s, abs=0.02) for s in (1.7, 1.0, 1.0, 1.3)]
    assert "scaled-codes" in codes(found)


def test_levels_that_the_codes_contradict(study: Path) -> None:
    low = seen(study, "flat", lambda x: np.minimum(x, np.quantile(x, 0.9)))
    assert "white-level-too-high" in codes(low)
    high = seen(study, "flat", white_level=Levels(values=(500.0,) * 4, source="metadata", tag="WhiteLevel"))
    assert "white-level-exceeded" in codes(high)


def test_a_picture_darker_than_black(study: Path) -> None:
    tag = Levels(values=(260.0,) * 4, source="metadata", tag="BlackLevel")
    assert "black-level-too-high" in codes(seen(study, "bias", black_level=tag))
    assert "black-level-too-high" not in codes(seen(study, "bias"))
    assert "black-level-too-high" not in codes(seen(study, "flat", black_level=tag))


def test_lines_that_take_turns(study: Path) -> None:
    def turns(x: np.ndarray) -> np.ndarray:
        x[:, 0::4] += 4.0
        x[:, 1::4] += 4.0
        return x

    found = [one for one in seen(study, "bias", turns).findings if one.code == "interleaved-lines"]
    assert len(found) == 1
    assert "columns" in found[0].message


def with_margins(study: Path, offset_dn: float, *, noise: float = 1.0) -> tuple[RawHeader, np.ndarray]:
    """Return the header of a bias frame whose upper 64 rows are masked pixels, and its mosaic changed there."""
    header = read_header(frame(study, "bias"))
    mosaic = decode(header, header.path.read_bytes()).astype(np.float64)
    mosaic[:64] = 256.0 + offset_dn + noise * (mosaic[:64] - 256.0)
    area = Area(64, 0, header.raw_height, header.raw_width)
    return replace(header, active_area=area, masked_areas=(Area(0, 0, 64, header.raw_width),)), np.round(mosaic)


@pytest.mark.parametrize(
    ("offset_dn", "noise", "expected"),
    [(0.0, 1.0, set()), (-7.0, 1.0, {"black-levels-disagree"}), (0.0, 2.0, {"optical-black-noisier"})],
)
def test_optical_black(study: Path, offset_dn: float, noise: float, expected: set[str]) -> None:
    header, mosaic = with_margins(study, offset_dn, noise=noise)
    data = bytearray(header.path.read_bytes())
    plain = decode(replace(header, active_area=Area(0, 0, header.raw_height, header.raw_width)), data)
    start = plain.__array_interface__["data"][0] - np.frombuffer(data, np.uint8).__array_interface__["data"][0]
    data[start : start + mosaic.size * 2] = mosaic.astype("<u2").tobytes()
    found = look_at(header, bytes(data), decode(header, data))
    assert len(found.masked) == 4
    assert codes(found) & {"black-levels-disagree", "optical-black-noisier"} == expected

"""The levels of the cameras in docs/levels.md: what frames say that bear them out, or contradict them."""

from pathlib import Path

import numpy as np
import pytest

from fullwell.raw.image import Area, Levels, RawHeader
from fullwell.workflow.masked import MaskedArea
from fullwell.workflow.signs.content import look_at
from fullwell.workflow.signs.rails import optical_black_findings


def masked(level_dn: float) -> tuple[MaskedArea, ...]:
    return tuple(
        MaskedArea(
            channel=channel, mean_dn=level_dn, std_error_dn=0.1, variance_dn2=4.0, dof=999.0, n=1000, declared=True
        )
        for channel in ("R", "G1", "G2", "B")
    )


@pytest.mark.parametrize(
    ("declared", "optical_black", "apart"),
    [(2047, 2047.2, False), (127, 127.3, False), (128, 143.0, True), (512, 511.4, False), (2056, 2049.0, True)],
)
def test_black_tags_against_masked_pixels(declared: float, optical_black: float, apart: bool) -> None:  # noqa: FBT001 - a column of the table
    tag = Levels(values=(float(declared),) * 4, source="metadata", tag="BlackLevel")
    found = optical_black_findings(masked(optical_black), tag)
    assert [one.code for one in found] == ["black-levels-disagree"] * apart


def test_a_default_of_zero_is_no_declaration() -> None:
    """Nikon D800E: nothing in the NEF, a 0 that the DNG converter added."""
    assert optical_black_findings(masked(600.0), Levels(values=(0.0,) * 4, source="default", tag="BlackLevel")) == ()


@pytest.mark.parametrize(
    ("camera", "declared", "ends_at", "clips", "code"),
    [
        ("Canon EOS 6D, specular", 15070, 15070, True, None),
        ("Canon EOS 6D, normal", 14558, 15070, True, "white-level-exceeded"),
        ("Panasonic", 4095, 4095, True, None),
        ("Panasonic, four codes below", 4095, 4091, True, "white-level-too-high"),
        ("Sony A6000", 15360, 16148, False, "white-level-exceeded"),
    ],
)
def test_white_tags_against_where_codes_end(
    camera: str,
    declared: int,
    ends_at: int,
    clips: bool,  # noqa: FBT001 - a column of the table
    code: str | None,
) -> None:
    rng = np.random.default_rng(len(camera))
    scene = rng.uniform(0.1, 1.3 if clips else 1.0, (256, 384)) * ends_at
    mosaic = np.minimum(np.round(scene), ends_at).astype(np.uint16)
    mosaic[:2, :2] = ends_at
    header = RawHeader(
        path=Path("a.raw"),
        format="dng",
        raw_width=384,
        raw_height=256,
        active_area=Area(0, 0, 256, 384),
        cfa="RGGB",
        bit_depth=14,
        white_level=Levels(values=(float(declared),) * 4, source="metadata", tag="WhiteLevel"),
    )
    found = {one.code for one in look_at(header, b"", mosaic).findings if one.code.startswith("white-level")}
    assert found == ({code} if code else set())

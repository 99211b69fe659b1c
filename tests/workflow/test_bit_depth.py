"""A stated bit depth is compared with the codes of the frames."""

from pathlib import Path

import numpy as np
import pytest
import tifffile

from fullwell.findings import Severity
from fullwell.frames.selection import Selection
from fullwell.frames.series import Camera
from fullwell.workflow.characterize import measure
from fullwell.workflow.options import Options


@pytest.mark.parametrize(("bit_depth", "warned"), [(8, True), (9, False), (None, False)])
def test_codes_above_the_stated_bit_depth_are_named(tmp_path: Path, bit_depth: int | None, warned: bool) -> None:  # noqa: FBT001 - pytest hands its parameters by name
    rng = np.random.default_rng(3)
    (tmp_path / "dark").mkdir()
    for n in range(3):
        mosaic = rng.integers(20, 30, (32, 32)).astype(np.uint16)
        mosaic[5, 7] = 256
        tifffile.imwrite(tmp_path / f"dark/exp1ms_{n}.tif", mosaic, photometric="minisblack", metadata=None)
    selection = Selection(cfa="mono", white_level=255.0, camera=Camera(bit_depth=bit_depth))
    results = measure(tmp_path, options=Options(selection=selection, workers=1)).results
    found = [one for one in results.findings if one.code == "codes-above-bit-depth"]
    assert len(found) == warned
    for one in found:
        assert one.severity is Severity.WARNING
        assert "256 DN" in one.message
        assert "bit depth 8" in one.message

"""What one run has compiled, the next one does not compile again."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np

from fullwell.kernels.compile_cache import forget_other_code
from fullwell.raw.write import write_dng

SCRIPT = """
import sys
from pathlib import Path
from numba.core import event
from fullwell.frames.selection import Selection
from fullwell.frames.study import load_study
from fullwell.workflow.reduce import reduce_study
study = load_study(Path(sys.argv[1]), Selection())
with event.install_recorder("numba:compile") as compiled:
    reduce_study(study, workers=2, tile=8, keep=[one.kind for one in study.series])
print(sum(one.is_start for _, one in compiled.buffer))
"""

FAST = """
import numpy as np
from fullwell.kernels.cosine_sums import cosine_sums
from fullwell.statistics.pattern import pattern
rng = np.random.default_rng(1)
plane = rng.normal(0.3, 2.0, (384, 512)).astype(np.float32)[::2, ::2]
for relative in (False, True):
    found = pattern(plane + np.float32(100 * relative), tile=64, relative=relative)
    print(found.variance.tolist(), found.inverse_square.tolist(), found.row_mean_square, found.column_mean_square)
y, x = np.linspace(-0.6, 0.6, 48), np.linspace(-0.8, 0.8, 61)
print(cosine_sums(y, x, rng.random((48, 61)), rng.random((48, 61)), (1.0, 0.01, 0.02, 0.1)).tolist())
"""


def compiled(study: Path) -> int:
    command = [sys.executable, "-c", SCRIPT, str(study)]
    return int(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def test_a_second_run_compiles_nothing(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    for folder, compression in (("flat", "none"), ("dark", "lossless-jpeg")):
        for number in range(7):
            path = tmp_path / folder / f"{number}.dng"
            path.parent.mkdir(exist_ok=True)
            mosaic = rng.integers(60, 200, (48, 64)).astype(np.uint16)
            write_dng(
                path,
                mosaic,
                cfa="RGGB",
                black_level=(64,) * 4,
                white_level=1023,
                exposure_s=0.01,
                iso=100,
                compression=compression,
            )
    compiled(tmp_path)
    assert compiled(tmp_path) == 0


def test_what_is_compiled_gives_the_same_bits_as_what_was_kept(tmp_path: Path) -> None:
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}

    def found() -> str:
        command = [sys.executable, "-c", FAST]
        return subprocess.run(command, check=True, capture_output=True, text=True, env=environment).stdout

    compiling, kept = found(), found()
    assert len(compiling.splitlines()) == 3
    assert compiling == kept


def test_what_other_sources_were_compiled_into_is_forgotten(tmp_path: Path) -> None:
    source, kept = tmp_path / "loops.py", tmp_path / "__pycache__"
    index, code = kept / "loops.add-1.py311.nbi", kept / "loops.add-1.py311.1.nbc"
    kept.mkdir()

    def compile_again() -> None:
        index.write_bytes(b"")
        code.write_bytes(b"")

    def are_there() -> list[bool]:
        forget_other_code(tmp_path)
        return [index.exists(), code.exists()]

    source.write_text("one = 1\n", encoding="utf-8")
    compile_again()
    assert are_there() == [False, False]
    compile_again()
    assert are_there() == [True, True]
    (tmp_path / "other.py").write_text("two = 2\n", encoding="utf-8")
    assert are_there() == [False, False]


def test_a_folder_without_sources_to_compile_is_left_as_it_is(tmp_path: Path) -> None:
    forget_other_code(tmp_path / "missing")
    assert not (tmp_path / "missing").exists()

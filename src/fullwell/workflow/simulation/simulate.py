"""A camera as raw files on disk: a config becomes a study that `characterize` reads by its folder names."""

import json
import shutil
from collections.abc import Sequence
from concurrent.futures import FIRST_EXCEPTION, Future, ThreadPoolExecutor, wait
from dataclasses import asdict, dataclass
from pathlib import Path, PurePosixPath
from typing import Final

from fullwell.errors import UsageError
from fullwell.files import foreign_in, holds_document, replaced_folder
from fullwell.findings import listed
from fullwell.frames.series import Kind
from fullwell.simulate.camera import camera_of, take
from fullwell.simulate.config import SimulationConfig, read_config
from fullwell.simulate.config_text import config_text, self_contained
from fullwell.simulate.files import suffix, write_frame
from fullwell.simulate.plan import PlannedFrame, plan
from fullwell.simulate.shot import Camera
from fullwell.simulate.truth import true_values
from fullwell.workflow.executor import Progress
from fullwell.workflow.simulation.preview import previewed, write_preview

TRUTH: Final = "truth.json"
SCHEMA: Final = "fullwell-truth/1"
PATCHES: Final = "PATCHES.csv"
CONFIG: Final = "config.toml"
INPUTS: Final = "inputs"


@dataclass(frozen=True, slots=True, kw_only=True)
class SimulatedStudy:
    """What was written.

    Parameters
    ----------
    root
        The study's folder.
    config
        What was simulated.
    frames
        Every frame, in the order in which they are numbered.

    """

    root: Path
    config: SimulationConfig
    frames: tuple[PlannedFrame, ...]


def simulate(config: Path, out: Path, *, workers: int, progress: Progress | None = None) -> SimulatedStudy:
    """Write the study that a config describes as raw files, with ``truth.json`` beside them.

    Parameters
    ----------
    config
        TOML file (RESULTS 6).
    out
        Folder to write: a missing or empty one, or one that holds an earlier simulation and nothing else, which is
        replaced.
    workers
        Threads; no bit of any frame depends on their number.
    progress
        Told of every frame; None for silence.

    Raises
    ------
    UsageError
        Where the config says something that is not allowed, or ``out`` must not be replaced.

    """
    return simulate_config(read_config(config), out, workers=workers, progress=progress)


def simulate_config(
    config: SimulationConfig, out: Path, *, workers: int, progress: Progress | None = None
) -> SimulatedStudy:
    """Write the study of a config that was read already; otherwise as `simulate`."""
    _require_replaceable(out)
    frames = plan(config)
    camera = camera_of(config)
    with replaced_folder(out) as folder:
        _write_frames(config, camera, frames, folder, workers=workers, progress=progress)
        _write_patches(camera, frames, folder)
        _write_config(config, folder)
        document = json.dumps(truth_document(config, frames), indent=1) + "\n"
        (folder / TRUTH).write_text(document, encoding="utf-8", newline="\n")
    return SimulatedStudy(root=out, config=config, frames=frames)


def truth_document(config: SimulationConfig, frames: Sequence[PlannedFrame]) -> dict[str, object]:
    """Return what ``truth.json`` says: parameters, true values, and how every frame was taken."""
    return {
        "schema": SCHEMA,
        "seed": config.seed,
        "camera": {"name": config.name, "voltage_swing_v": config.voltage_swing_v, **asdict(config.sensor)},
        "lens": asdict(config.lens),
        "truth": [asdict(value) for value in true_values(config)],
        "frames": [
            {"path": f"{frame.name}{suffix(config)}", "kind": frame.kind.value, **asdict(frame.exposure)}
            for frame in frames
        ],
    }


def _write_frames(
    config: SimulationConfig,
    camera: Camera,
    frames: Sequence[PlannedFrame],
    folder: Path,
    *,
    workers: int,
    progress: Progress | None,
) -> None:
    if progress is not None:
        progress.start(len(frames))

    shown = previewed(frames) if config.output.preview else frozenset[str]()

    def write(frame: PlannedFrame) -> None:
        mosaic = take(camera, frame.exposure)
        write_frame(folder, frame.name, mosaic, config, frame.exposure)
        if frame.name in shown:
            write_preview(folder, frame, mosaic, camera, config)
        if progress is not None:
            progress.advance()

    with ThreadPoolExecutor(max_workers=max(workers, 1), thread_name_prefix="simulate") as pool:
        futures = [pool.submit(write, frame) for frame in frames]
        try:
            _wait_for(futures)
        except BaseException:
            pool.shutdown(wait=True, cancel_futures=True)
            raise


def _write_patches(camera: Camera, frames: Sequence[PlannedFrame], folder: Path) -> None:
    """Write where the patches are beside the shots of every ISO, where `characterize` looks for it."""
    if camera.chart is not None:
        for place in {frame.name.rpartition("/")[0] for frame in frames if frame.kind is Kind.CHART}:
            camera.chart.write(folder / place / PATCHES)


def _write_config(config: SimulationConfig, folder: Path) -> None:
    """Write the config that was used, and beside it every file that it names."""
    table, files = self_contained(config, INPUTS)
    for source in files:
        (folder / INPUTS).mkdir(exist_ok=True)
        shutil.copyfile(source, folder / INPUTS / source.name)
    (folder / CONFIG).write_text(config_text(table), encoding="utf-8", newline="\n")


def _wait_for(futures: Sequence[Future[None]]) -> None:
    done, _ = wait(futures, return_when=FIRST_EXCEPTION)
    for future in done:
        future.result()


def _require_replaceable(out: Path) -> None:
    target = out.resolve()
    if target.exists() and not target.is_dir():
        raise UsageError(f"{out} is a file; name a folder for the frames with -o.")
    if target.is_dir() and any(target.iterdir()) and not holds_document(target, TRUTH, schema=SCHEMA):
        raise UsageError(
            f"{out} holds something other than simulated frames and is left untouched; "
            "name a new or empty folder with -o."
        )
    foreign = foreign_in(target, _own(target)) if target.is_dir() else []
    if foreign:
        raise UsageError(
            f"{out} would be replaced, but beside simulated frames it holds {listed(foreign)}; move that away or name "
            "another folder with -o."
        )


def _own(target: Path) -> frozenset[str]:
    """Return what an earlier simulation wrote into its folder."""
    truth = target / TRUTH
    frames = json.loads(truth.read_text(encoding="utf-8"))["frames"] if truth.is_file() else []
    return frozenset({TRUTH, CONFIG, INPUTS, *(PurePosixPath(frame["path"]).parts[0] for frame in frames)})

"""Whether what was said about a camera fits the files: what contradicts them is used all the same, with a warning."""

import re
from collections import Counter
from collections.abc import Iterator, Sequence

from fullwell.findings import Finding, Severity
from fullwell.frames.cameras import is_built_in
from fullwell.frames.reading import Reading
from fullwell.frames.series import Camera
from fullwell.raw.image import Levels


def fact_findings(
    readings: Sequence[Reading], *, given: Camera | None, camera: Camera, white: Levels | None
) -> tuple[Finding, ...]:
    """Return what is to be said about facts that the files contradict.

    Parameters
    ----------
    readings
        The frames that are used.
    given
        The camera of ``--camera``.
    camera
        All facts, those of the manifest included.
    white
        The study's white level [DN].

    """
    return (*_camera_differs(readings, given), *_white_above_bit_depth(camera, white))


def _camera_differs(readings: Sequence[Reading], given: Camera | None) -> Iterator[Finding]:
    """Compare the name of a built-in camera with the files' own; in a user's file it may be any text."""
    if given is None or given.name is None or not is_built_in(given):
        return
    differing = [one for one in readings if one.frame.header.model and not _is_called(given.name, one)]
    if differing:
        names = Counter(f"{one.frame.header.make or ''} {one.frame.header.model}".strip() for one in differing)
        yield Finding(
            code="camera-differs",
            severity=Severity.WARNING,
            message=(
                f"--camera gives the facts of the {given.name}, but {len(differing)} frames name another camera: "
                f"{', '.join(sorted(names))}. Its pixel pitch, voltage swing and base ISO may not hold for these."
            ),
            files=tuple(sorted(one.frame.name for one in differing)),
        )


def _is_called(name: str, reading: Reading) -> bool:
    """Return whether a frame names this camera, with its make before the model or without."""
    make, model = _plain(reading.frame.header.make or ""), _plain(reading.frame.header.model or "")
    return _plain(name) in {model, make + model, model.removeprefix(make)}


def _plain(text: str) -> str:
    return re.sub(r"[\W_]", "", text.casefold())


def _white_above_bit_depth(camera: Camera, white: Levels | None) -> Iterator[Finding]:
    """Compare the white level with a stated bit depth; a file's own may be that of codes before its linearization."""
    if camera.bit_depth is None or white is None:
        return
    highest = 2**camera.bit_depth - 1
    if max(white.values) > highest:
        yield Finding(
            code="white-level-above-bit-depth",
            severity=Severity.WARNING,
            message=(
                f"The white level {max(white.values):g} DN ({white.source}) lies above {highest} DN, the highest code "
                f"of the stated bit depth {camera.bit_depth}. Correct bit_depth or white_level in [camera]."
            ),
        )

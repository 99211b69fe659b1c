"""What the shots say about how they were taken, and what to do better the next time."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from fullwell.findings import Finding, Severity, listed
from fullwell.frames.series import Study
from fullwell.statistics.chart import PatchPoint
from fullwell.workflow.measure.chart.levels import ChartLevels
from fullwell.workflow.measure.chart.shots import Scene, Shots

LARGEST = 0.75
"""Share of the frame's width or height that a chart may take: beyond it lenses shade."""
OFF_CENTRE = 0.15
"""Distance of the chart's middle from that of the frame, as a share of width or height, from where it is said."""
UNDER = 6.0
"""Ratio of exposures from where on the darker one counts as three stops under."""
FEWEST = 5
"""Patches that a noise model takes at least."""
LEVEL_ERRORS = 5.0
"""Standard errors by which a denser patch must be lighter to be remarked upon."""


def advice(study: Study, shots: Shots, levels: ChartLevels) -> tuple[Finding, ...]:
    """Return everything that is to be said about the shots themselves."""
    return (
        *_clipping(shots),
        *_framing(shots),
        *_iso(study, shots),
        *_bracket(shots),
        *_densities(shots),
        *_darkest(shots, levels),
        *_steps(shots),
    )


def without_signal(shots: Shots) -> tuple[Finding, ...]:
    """Return an error for frames that show no chart at all: all patches alike."""
    findings: list[Finding] = []
    for scene in shots.scenes:
        points = scene.brightest.points
        if all(point.lowest == point.highest for point in points):
            codes = sorted({point.lowest for point in points})
            message = (
                f"{scene.name} holds one value only in every patch ({listed([str(code) for code in codes])} DN): "
                "nothing was exposed, or everything clips"
            )
        elif _contrast(points) < 1.0:
            message = (
                f"the patches of {scene.name} do not differ from each other beyond their noise: no chart is to be seen "
                "in them; look at the exposure and at where the patches are"
            )
        else:
            continue
        files = tuple(file for exposure in scene.exposures for file in exposure.files)
        findings.append(Finding(code="image-without-signal", severity=Severity.ERROR, message=message, files=files))
    return tuple(findings)


def too_few_patches(shots: Shots) -> tuple[Finding, ...]:
    """Return an error where fewer than five patches of a channel are free of clipping."""
    few: list[str] = []
    for channel in shots.channels:
        names = {point.patch for point in shots.points(channel) if point.admitted}
        if len(names) < FEWEST:
            few.append(f"{channel} {len(names)}")
    if not few:
        return ()
    message = (
        f"too few patches can be used at {shots.bursts.label} ({', '.join(few)}; at least {FEWEST} of a channel are "
        "needed): the others clip, or are too small; the noise model of these channels is not measured"
    )
    return (Finding(code="too-few-patches", severity=Severity.ERROR, message=message),)


def _contrast(points: Sequence[PatchPoint]) -> float:
    """Return by how much the patches of a channel differ, in standard deviations of a single pixel; the largest."""
    found = 0.0
    for channel in {point.channel for point in points}:
        own = [point for point in points if point.channel == channel]
        noise = float(np.median([max(point.variance_dn2, 1e-12) for point in own])) ** 0.5
        found = max(found, float(np.ptp([point.mean_dn for point in own])) / noise)
    return found


def _clipping(shots: Shots) -> tuple[Finding, ...]:
    findings: list[Finding] = []
    for scene in shots.scenes:
        points = scene.brightest.points
        high = list(dict.fromkeys(point.patch for point in points if point.clipped_high > 0.001 or point.full))
        low = list(dict.fromkeys(point.patch for point in points if point.clipped_low > 0.001))
        if len(high) >= 2:
            message = (
                f"{scene.name} is over-exposed: {len(high)} patches clip or are full ({listed(high)}); their light "
                "fogs the dark patches and they are not used; expose so that one patch just clips"
            )
            findings.append(Finding(code="over-exposed", severity=Severity.WARNING, message=message))
        elif not high:
            message = (
                f"no patch of {scene.name} clips: saturation is a lower bound; expose so that the lightest patch just "
                "clips"
            )
            findings.append(Finding(code="no-patch-clips", severity=Severity.INFO, message=message))
        if low:
            message = (
                f"patches of {scene.name} are cut off at code 0 ({listed(low)}) and not used: somebody has subtracted "
                "the black level; use the camera's own raw files"
            )
            findings.append(Finding(code="black-clipped", severity=Severity.WARNING, message=message))
    return tuple(findings)


def _framing(shots: Shots) -> tuple[Finding, ...]:
    findings: list[Finding] = []
    for scene in shots.scenes:
        left, top, right, bottom = _bounds(scene)
        share = max((right - left) / shots.width, (bottom - top) / shots.height)
        away = max(abs((left + right) / 2 / shots.width - 0.5), abs((top + bottom) / 2 / shots.height - 0.5))
        if share > LARGEST:
            message = (
                f"the chart takes {100 * share:.0f} % of the frame of {scene.name}: the lens darkens towards the "
                "corners; move back until it fills the middle half"
            )
            findings.append(Finding(code="chart-too-large", severity=Severity.INFO, message=message))
        if away > OFF_CENTRE:
            message = (
                f"the chart of {scene.name} is off the centre of the frame by {100 * away:.0f} %: centre it, where the "
                "lens is even and its flare least"
            )
            findings.append(Finding(code="chart-off-centre", severity=Severity.INFO, message=message))
    return tuple(findings)


def _bounds(scene: Scene) -> tuple[int, int, int, int]:
    patches = scene.patches
    return (
        min(patch.x for patch in patches),
        min(patch.y for patch in patches),
        max(patch.x + patch.width for patch in patches),
        max(patch.y + patch.height for patch in patches),
    )


def _iso(study: Study, shots: Shots) -> tuple[Finding, ...]:
    iso, lowest = shots.bursts.iso, study.camera.base_iso
    if iso is None or (lowest is not None and iso <= 1.01 * lowest) or (lowest is None and iso <= 100.0):
        return ()
    known = f"above the camera's lowest, {lowest:g}" if lowest is not None else "and higher ISOs amplify more"
    message = (
        f"the shots are at ISO {iso:g}, {known}: the converter may clip before the pixels are full, and saturation "
        "capacity is then not the sensor's; shoot at the lowest ISO (camera facts: base_iso)"
    )
    return (Finding(code="iso-not-lowest", severity=Severity.INFO, message=message),)


def _bracket(shots: Shots) -> tuple[Finding, ...]:
    if any(_spread(scene) >= UNDER for scene in shots.scenes):
        return ()
    message = (
        "no shot of the same scene is three to four stops under: it would tell the black level and keep the light of "
        "the bright patches off the dark ones; add one at 1/8 to 1/16 of the exposure"
    )
    return (Finding(code="no-dark-exposure", severity=Severity.INFO, message=message),)


def _spread(scene: Scene) -> float:
    """Return how much lighter a scene's first exposure is than its last, by patches that clip in neither."""
    pairs = [
        (bright.mean_dn, dark.mean_dn)
        for bright, dark in zip(scene.exposures[0].points, scene.exposures[-1].points, strict=True)
        if bright.admitted and dark.admitted
    ]
    if len(scene.exposures) < 2 or not pairs:
        return 1.0
    ranges = np.ptp(np.array(pairs), axis=0)
    return float(ranges[0] / max(ranges[1], 1e-9))


def _densities(shots: Shots) -> tuple[Finding, ...]:
    """Say where a denser patch is lighter: then patches or densities are mixed up."""
    findings: list[Finding] = []
    for scene in shots.scenes:
        for channel in shots.channels:
            points = [point for point in scene.brightest.of(channel) if point.density is not None]
            points.sort(key=lambda point: (point.density or 0.0, -point.mean_dn))
            wrong = [
                f"{lighter.patch} above {darker.patch}"
                for darker, lighter in pairwise(points)
                if lighter.density != darker.density and _lighter(lighter, darker)
            ]
            if wrong:
                message = (
                    f"the densities of {scene.name} do not decrease with the level: denser, but lighter in {channel} "
                    f"are {listed(wrong)}; names or densities are mixed up, or light is reflected in the chart"
                )
                findings.append(Finding(code="densities-disagree", severity=Severity.WARNING, message=message))
                break
    return tuple(findings)


def _lighter(one: PatchPoint, other: PatchPoint) -> bool:
    """Tell whether a patch is lighter beyond noise and beyond a hundredth, which uneven light may cause."""
    errors = [point.variance_dn2 / (point.n * point.frames) for point in (one, other)]
    return one.mean_dn - other.mean_dn > max(LEVEL_ERRORS * sum(errors) ** 0.5, 0.01 * abs(other.mean_dn))


def _darkest(shots: Shots, levels: ChartLevels) -> tuple[Finding, ...]:
    below: list[str] = []
    for channel in shots.channels:
        black = levels.of(channel)
        points = [point for point in shots.points(channel) if point.admitted]
        if not points:
            continue
        darkest = min(points, key=lambda point: point.mean_dn)
        error = (darkest.variance_dn2 / (darkest.n * darkest.frames)) ** 0.5
        if darkest.mean_dn < black.level.value - 4.0 * (error + black.error_dn):
            below.append(f"{channel} {darkest.patch} {darkest.mean_dn:.2f} DN, black {black.level.value:.2f} DN")
    if not below:
        return ()
    message = (
        f"patches lie below the black level ({'; '.join(below)}), where no light can be: the black level is too high; "
        "k_dark and dynamic range are wrong with it"
    )
    return (Finding(code="black-level-above-patches", severity=Severity.WARNING, message=message),)


def _steps(shots: Shots) -> tuple[Finding, ...]:
    if shots.step_dn == 1:
        return ()
    message = (
        f"only every {shots.step_dn}th code occurs: the file holds fewer bits than it could, scaled up; figures in DN "
        "are those of the file's codes, and quantization is that of the wider step"
    )
    return (Finding(code="codes-missing", severity=Severity.INFO, message=message),)

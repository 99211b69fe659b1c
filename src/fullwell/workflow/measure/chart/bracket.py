"""The black level from exposures of one still scene (METHOD 2.3 (i), 2.5)."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fullwell.fit.exposure_bracket import ExposureBracket, fit_exposure_bracket
from fullwell.fit.offset_drift import frame_drift, repeat_levels
from fullwell.statistics.chart import PatchPoint
from fullwell.units import Measured
from fullwell.workflow.measure.chart.line_noise import LineNoise
from fullwell.workflow.measure.chart.noise_model import ChartModel
from fullwell.workflow.measure.chart.shots import Scene, Shots

SIGNIFICANT = 2.0
"""Standard errors at which the offset is said to move from frame to frame."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Bracket:
    """One scene's exposures, solved for some channels together.

    Parameters
    ----------
    scene
        Its number.
    channels
        Those that share the offset.
    solved
        The bracket; its columns are the patches of the first channel, then those of the second, ...

    """

    scene: int
    channels: tuple[str, ...]
    solved: ExposureBracket


def solve_brackets(
    shots: Shots,
    models: Sequence[ChartModel | None],
    channels: Sequence[str],
    *,
    lines: LineNoise,
    guess_dn: float,
    range_dn: float,
) -> tuple[Bracket, ...]:
    """Return what every scene with two exposures or more says about the offset that some channels share.

    Parameters
    ----------
    shots
        The scenes.
    models
        Noise models of all channels at the level ``guess_dn``, for the weights; None: as measured.
    channels
        Which channels to take together.
    lines
        Noise of rows and columns, which patches share.
    guess_dn
        A black level that the models go by [DN].
    range_dn
        White level less black level [DN].

    """
    found: list[Bracket] = []
    fixed = {channel: _fixed(models[index]) for index, channel in enumerate(shots.channels)}
    for number, scene in enumerate(shots.scenes):
        if len(scene.exposures) < 2:
            continue
        points = [[point for channel in channels for point in one.of(channel)] for one in scene.exposures]
        noises = np.array(
            [[_noise(point, models[shots.channels.index(point.channel)], guess_dn) for point in row] for row in points]
        )
        pixels = np.array([[point.n for point in row] for row in points])
        frames = np.array([one.frames for one in scene.exposures])
        own = noises / (pixels * frames[:, None]) + [[fixed[point.channel] for point in row] for row in points] / pixels
        own_by_line, covariance = _parted(lines.of_means(points, scene.patches, cfa=shots.cfa))
        try:
            solved = fit_exposure_bracket(
                [[point.mean_dn for point in row] for row in points],
                own + own_by_line,
                used=[[point.admitted for point in row] for row in points],
                digital_maximum=range_dn,
                drift_dn=_drift(scene, points, noises / pixels, lines=lines, cfa=shots.cfa, guess_dn=guess_dn),
                frames=frames,
                covariance_dn2=covariance,
            )
        except ValueError:
            continue
        found.append(Bracket(scene=number, channels=tuple(channels), solved=solved))
    return tuple(found)


def _parted(covariance: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the variances of means of shape (E, N), and their covariance without them, shape (E, N, E, N)."""
    shape = covariance.shape[:2]
    square = covariance.reshape(math.prod(shape), -1)
    return np.diagonal(square).reshape(shape), (square - np.diag(np.diagonal(square))).reshape(covariance.shape)


def _noise(point: PatchPoint, model: ChartModel | None, guess_dn: float) -> float:
    """Return the part of a single frame's variance that is new in every frame: fixed pattern scales with light.

    Without bursts the pattern of the dark, which neither scales nor changes, is in it [DN^2].
    """
    measured = point.variance_dn2 if point.admitted else np.nan
    if model is None:
        return float(measured)
    line = model.fit.coefficients[0] + model.fit.coefficients[1] * (point.mean_dn - guess_dn)
    return float(line) if line > 0.0 else float(measured)


def _fixed(model: ChartModel | None) -> float:
    """Return the pattern of the dark, which no number of frames lowers, where bursts tell it apart [DN^2]."""
    return max(float(model.fit.coefficients[-1]), 0.0) if model is not None and model.fit.has_bursts else 0.0


def _drift(
    scene: Scene,
    points: Sequence[Sequence[PatchPoint]],
    variances: NDArray[np.float64],
    *,
    lines: LineNoise,
    cfa: str,
    guess_dn: float,
) -> float:
    """Return by how much the offset moves from frame to frame, 0 where that is not seen [DN].

    ``variances`` are those that pixels give the means of single frames, shape (E, N).
    """
    found: list[Measured] = []
    for row, own in zip(points, variances, strict=True):
        if row[0].frames < 2:
            continue
        kept = [index for index, point in enumerate(row) if point.admitted]
        chosen = [row[index] for index in kept]
        own_by_line, covariance = _parted(lines.moving(chosen, scene.patches, cfa=cfa))
        means = np.array([point.frame_means_dn for point in chosen]).T
        single = np.broadcast_to(own[kept] + own_by_line[0], means.shape)
        found.append(frame_drift(*repeat_levels(means, single, offset_dn=guess_dn, covariance_dn2=covariance[0, :, 0])))
    known = [one for one in found if one.std_error]
    if not known:
        return 0.0
    weight = np.array([one.dof or 1.0 for one in known])
    value = float(weight @ [one.value for one in known] / weight.sum())
    error = float(np.linalg.norm(weight * [one.std_error or 0.0 for one in known]) / weight.sum())
    return value**0.5 if value > SIGNIFICANT * error else 0.0

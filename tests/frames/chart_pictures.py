"""Simulated pictures of charts: patches under a projective map in a scene, blurred, with shot and read noise."""

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from fullwell.frames.chart.definition import ChartDefinition

BLACK = 512.0
WHITE = 16383.0
WHITE_BALANCE = (0.55, 1.0, 0.65)
CROSSTALK = np.array([[0.80, 0.17, 0.03], [0.12, 0.76, 0.12], [0.02, 0.20, 0.78]])
Corners = tuple[tuple[float, float], ...]


def turned_corners(
    centre: tuple[float, float], *, width: float, aspect: float, turn: float = 0.0, tilt: float = 0.0
) -> Corners:
    """Return a chart's corners: turned clockwise [degree], its right side smaller by the share ``tilt``."""
    x = np.array((-0.5, 0.5, 0.5, -0.5)) * width
    y = np.array((-0.5, -0.5, 0.5, 0.5)) * width / aspect
    shrink = np.array((1.0, 1.0 - tilt, 1.0 - tilt, 1.0))
    angle = np.radians(turn)
    across, down = x * (1.0 - tilt / 2), y * shrink
    return tuple(
        (
            float(centre[0] + a * np.cos(angle) - d * np.sin(angle)),
            float(centre[1] + a * np.sin(angle) + d * np.cos(angle)),
        )
        for a, d in zip(across, down, strict=True)
    )


def textured_scene(rng: np.random.Generator, height: int, width: int) -> NDArray[np.float64]:
    """Return a colourful scene of soft clouds and hard-edged boxes, reflectances, shape (height, width, 3)."""
    small = ndimage.gaussian_filter(rng.normal(size=(height // 8 + 1, width // 8 + 1, 3)), (6, 6, 0))
    clouds = np.kron(small, np.ones((8, 8, 1)))[:height, :width] / small.std()
    scene = 0.25 * np.exp(0.6 * ndimage.gaussian_filter(clouds, (4, 4, 0)))
    for _ in range(40):
        x, y = rng.integers(0, width), rng.integers(0, height)
        w, h = rng.integers(8, width // 6, size=2)
        scene[y : y + h, x : x + w] = rng.uniform(0.02, 0.9, size=3)
    return scene


def draw_chart(
    scene: NDArray[np.float64], definition: ChartDefinition, corners: Corners, *, surround: float, margin: float = 0.06
) -> None:
    """Draw a chart upon a scene, in place, on a board of reflectance ``surround`` that reaches past its corners."""
    height, width, _ = scene.shape
    inverse = np.linalg.inv(_projective(np.array(corners)))
    rows, columns = np.mgrid[0:height, 0:width]
    points = np.stack((columns + 0.5, rows + 0.5, np.ones_like(rows)), axis=-1) @ inverse.T
    u, v = points[..., 0] / points[..., 2], points[..., 1] / points[..., 2]
    front = points[..., 2] > 0
    across = margin * max(1.0, 1.0 / definition.aspect)
    down = margin * max(1.0, definition.aspect)
    scene[front & (u > -across) & (u < 1 + across) & (v > -down) & (v < 1 + down)] = surround
    for patch in definition.patches:
        scene[front & (abs(u - patch.x) < patch.width / 2) & (abs(v - patch.y) < patch.height / 2)] = patch.rgb


def photograph(
    scene: NDArray[np.float64],
    rng: np.random.Generator,
    *,
    cfa: str = "RGGB",
    exposure: float = 12_000.0,
    electrons_per_dn: float = 2.0,
    read_noise_dn: float = 3.0,
    flare: float = 1e-3,
    blur: float = 1.2,
    falloff: float = 0.2,
) -> NDArray[np.uint16]:
    """Return the mosaic of a scene: lens blur, falloff and flare, colour filters that mix, noise, clipping."""
    height, width, _ = scene.shape
    light = np.stack([ndimage.gaussian_filter(scene[..., one], blur) for one in range(3)], axis=-1)
    light = light + flare * light.mean(axis=(0, 1))
    rows, columns = np.mgrid[0:height, 0:width]
    radius = ((rows - height / 2) ** 2 + (columns - width / 2) ** 2) / (height**2 + width**2) * 4
    light *= (1.0 - falloff * radius)[..., None]
    planes = light @ CROSSTALK.T * WHITE_BALANCE
    if cfa == "mono":
        mosaic = planes.mean(axis=2)
    else:
        which = np.array(["RGB".index(letter) for letter in cfa]).reshape(2, 2)
        site = which[rows % 2, columns % 2]
        mosaic = np.take_along_axis(planes, site[..., None], axis=2)[..., 0]
    electrons = rng.poisson(mosaic * exposure * electrons_per_dn)
    noisy = electrons / electrons_per_dn + BLACK + rng.normal(scale=read_noise_dn, size=mosaic.shape)
    return np.clip(np.round(noisy), 0, WHITE).astype(np.uint16)


def true_corners_of_patches(definition: ChartDefinition, corners: Corners, *, share: float) -> NDArray[np.float64]:
    """Return the corners of the patches, shrunk to a share of their edges, shape (patches, 4, 2) [pixel]."""
    offsets = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]) * share
    places = definition.centres[:, None, :] + offsets * definition.sizes[:, None, :]
    points = np.concatenate((places, np.ones((*places.shape[:2], 1))), axis=2) @ _projective(np.array(corners)).T
    return points[..., :2] / points[..., 2:]


def _projective(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the map of the unit square upon four corners, by eight linear equations."""
    rows, right = [], []
    for (u, v), (x, y) in zip(((0, 0), (1, 0), (1, 1), (0, 1)), corners, strict=True):
        rows += [(u, v, 1, 0, 0, 0, -u * x, -v * x), (0, 0, 0, u, v, 1, -u * y, -v * y)]
        right += [x, y]
    return np.append(np.linalg.solve(np.array(rows, dtype=float), np.array(right)), 1.0).reshape(3, 3)

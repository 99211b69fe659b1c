"""All models of a plane's shading, and the one to use (METHOD 6.3)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from fullwell.fit.shading.data import ShadingData
from fullwell.fit.shading.surface import ShadingModel

MODELS: Final = ("cos4-fixed", "cos4", "poly22", "radial", "poly44", "poly66", "poly88", "p-spline")
"""All models, from few terms to many."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ShadingFits:
    """The models of one plane and the choice among them.

    Parameters
    ----------
    models
        By name, from few effective terms to many.
    chosen
        Name of the smallest model whose cross-validation is within one standard error of the best.
    failures
        By name, a sentence on why a model could not be fitted.
    robust_weight
        Weight that each bin got by its residual, shape (V, H), 0 for an outlier to 1 [1]; None without robust fits.

    """

    models: Mapping[str, ShadingModel]
    chosen: str
    failures: Mapping[str, str]
    robust_weight: NDArray[np.float64] | None

    @property
    def best(self) -> ShadingModel:
        """The chosen model."""
        return self.models[self.chosen]


def fit_shading(data: ShadingData, *, models: Sequence[str] = MODELS, robust: bool = False) -> ShadingFits:
    """Return the models of a plane's shading (METHOD 6.2) and the choice among them (METHOD 6.3).

    Parameters
    ----------
    data
        Bins of the plane.
    models
        Which to fit; ``cos4-fixed`` is left out where focal length or pitch is unknown.
    robust
        Give little weight to bins far from the surface, such as dust (Tukey's biweight, METHOD 6.4).

    Raises
    ------
    ValueError
        Where a name is unknown or no model can be fitted; the sentence says why.

    """
    raise NotImplementedError

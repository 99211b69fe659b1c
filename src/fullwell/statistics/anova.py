"""Three-way analysis of variance of frame t x row v x column h, from exact marginal sums (METHOD 3.5)."""

from dataclasses import dataclass

from fullwell.statistics.series import MeanSquares


@dataclass(frozen=True, slots=True, kw_only=True)
class MarginalSquares:
    """Sums of squares of the marginal sums of x[t, v, h] over what their name leaves out, as exact integers.

    Parameters
    ----------
    frames, rows, columns
        T, M, N.
    total
        Sum of x.
    tvh
        Sum of x^2.
    t, v, h, tv, th, vh
        For example ``tv``: the sum over frames and rows of the squared sum over columns.

    """

    frames: int
    rows: int
    columns: int
    total: int
    tvh: int
    t: int
    v: int
    h: int
    tv: int
    th: int
    vh: int

    def mean_squares(self) -> MeanSquares:
        """Return the seven mean squares, each rounded once; NaN where there are no degrees of freedom [DN^2]."""
        t, m, n = self.frames, self.rows, self.columns
        mean = self.total**2
        of_t, of_v, of_h = self.t * t, self.v * m, self.h * n
        of_tv, of_th, of_vh = self.tv * t * m, self.th * t * n, self.vh * m * n
        rest = self.tvh * t * m * n - of_tv - of_th - of_vh + of_t + of_v + of_h - mean
        common = t * m * n
        return MeanSquares(
            t=_ratio(of_t - mean, common * (t - 1)),
            v=_ratio(of_v - mean, common * (m - 1)),
            h=_ratio(of_h - mean, common * (n - 1)),
            tv=_ratio(of_tv - of_t - of_v + mean, common * (t - 1) * (m - 1)),
            th=_ratio(of_th - of_t - of_h + mean, common * (t - 1) * (n - 1)),
            vh=_ratio(of_vh - of_v - of_h + mean, common * (m - 1) * (n - 1)),
            tvh=_ratio(rest, common * (t - 1) * (m - 1) * (n - 1)),
        )


def _ratio(numerator: int, denominator: int) -> float:
    return numerator / denominator if denominator else float("nan")

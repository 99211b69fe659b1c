"""Noise that rows or columns have in common widens the scatter of a variance (METHOD 1.8)."""


def dof_divisor(*, rows: int, columns: int, row_share: float, column_share: float = 0.0) -> float:
    """Return what the degrees of freedom of the variance of a patch are to be divided by.

    Parameters
    ----------
    rows, columns
        Size of the patch [pixel of the plane].
    row_share, column_share
        Share of the variance that the pixels of a row, or of a column, have in common; shares below zero count as none
        [1].

    Examples
    --------
    >>> round(dof_divisor(rows=50, columns=50, row_share=0.1), 2)
    1.49

    """
    return 1.0 + (columns - 1) * max(row_share, 0.0) ** 2 + (rows - 1) * max(column_share, 0.0) ** 2

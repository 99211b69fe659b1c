"""Light becomes an expected number of photo-electrons; chance comes in with the charge."""

from fullwell.simulate.shot import FloatArray, Shot


def expected_electrons(illumination: FloatArray, shot: Shot) -> FloatArray:
    """Return the mean photo-electrons of a pixel without response non-uniformity [e-].

    Parameters
    ----------
    illumination
        Light at each pixel, response applied [1].
    shot
        What is taken.

    """
    illumination *= shot.exposure.electrons
    return illumination

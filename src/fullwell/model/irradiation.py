"""Photons that hit a pixel, from the irradiance (EMVA1288 (3), (4))."""

from typing import Final

PLANCK_EMVA: Final = 6.6260755e-34
"""Planck's constant as the standard has it [J s]; the exact one is larger by 8e-7 of it, relative."""

PLANCK: Final = 6.62607015e-34
"""Planck's constant [J s]."""

LIGHT_SPEED: Final = 299792458.0
"""Speed of light [m/s]."""


def photons_per_pixel(
    *,
    area_um2: float,
    exposure_s: float,
    wavelength_nm: float,
    irradiance_uw_cm2: float,
    planck: float = PLANCK_EMVA,
) -> float:
    """Return the mean number of photons per pixel.

    Parameters
    ----------
    area_um2
        Area of a pixel [um^2].
    exposure_s
        Time of irradiation [s].
    wavelength_nm
        Centroid of the spectrum [nm].
    irradiance_uw_cm2
        At the sensor [uW/cm^2].
    planck
        Planck's constant [J s].

    Examples
    --------
    >>> round(photons_per_pixel(area_um2=11.9, exposure_s=2e-3, wavelength_nm=530, irradiance_uw_cm2=1.5), 6)
    952.504427

    """
    energy_j = irradiance_uw_cm2 * 1e-2 * area_um2 * 1e-12 * exposure_s
    return energy_j * wavelength_nm * 1e-9 / (planck * LIGHT_SPEED)

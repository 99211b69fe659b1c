"""The contract between measuring and simulating: every parameter of a sensor, in the units it is thought of in.

Charge is in electrons before the amplifier, levels in DN after it, and fractions are fractions.
"""

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorParameters:
    """A sensor.

    Parameters
    ----------
    width, height
        Size of the mosaic [pixel].
    cfa
        Order at the top-left pixel, or ``mono``.
    bit_depth
        Bits of the converter [bit].
    black_level
        Level without signal per CFA site, row-major [DN].
    white_level
        Highest code the camera writes [DN].
    base_iso
        ISO at which the amplification is 1.
    system_gain
        DN per electron at the base ISO; grows with the ISO [DN/e-].
    full_well
        Charge a pixel holds [e-].
    response
        Electrons per unit of light for each CFA site, row-major, relative to a response of 1 [1].
    read_noise
        Temporal noise of each pixel before the amplifier [e-].
    read_noise_row, read_noise_column, read_noise_frame
        Temporal noise that a row, a column or a frame has in common, before the amplifier [e-].
    read_noise_post
        Temporal noise of each pixel after the amplifier [DN].
    rts_pixels, rts_amplitude
        Share of pixels that jump between two levels, and how far each level is from their mean [1], [e-].
    dark_current, dark_current_spread
        Rate at the reference temperature, and its spread over pixels [e-/s].
    dark_current_doubling_c, dark_current_reference_c
        Warming that doubles the dark current, None where it does not depend on the temperature [K]; and the
        temperature that the rates belong to [deg C].
    hot_pixels, hot_pixel_current
        Share of pixels that have more dark current than others, and how much more on average [1], [e-/s].
    dsnu, dsnu_row, dsnu_column
        Spread of the levels of pixels, rows and columns, before the amplifier [e-].
    prnu, prnu_row, prnu_column
        Spread of the responses of pixels, rows and columns as a fraction [1].
    nonlinearity
        Share of the signal that is lost at full well, in proportion to the signal [1].
    blooming
        Share of the charge beyond full well that flows on into the pixels above and below [1].
    brighter_fatter
        Share of the shot variance lost per electron of charge, to the neighbours [1/e-].
    dual_conversion_ratio
        Amplification of the dark half of the range over that of the bright one; None for one amplification [1].
    pixel_pitch_um
        Distance of two pixels [um].

    """

    width: int
    height: int
    cfa: str
    bit_depth: int
    black_level: tuple[float, ...]
    white_level: int
    base_iso: float
    system_gain: float
    full_well: float
    response: tuple[float, ...]
    read_noise: float = 0.0
    read_noise_row: float = 0.0
    read_noise_column: float = 0.0
    read_noise_frame: float = 0.0
    read_noise_post: float = 0.0
    rts_pixels: float = 0.0
    rts_amplitude: float = 0.0
    dark_current: float = 0.0
    dark_current_spread: float = 0.0
    dark_current_doubling_c: float | None = None
    dark_current_reference_c: float = 20.0
    hot_pixels: float = 0.0
    hot_pixel_current: float = 0.0
    dsnu: float = 0.0
    dsnu_row: float = 0.0
    dsnu_column: float = 0.0
    prnu: float = 0.0
    prnu_row: float = 0.0
    prnu_column: float = 0.0
    nonlinearity: float = 0.0
    blooming: float = 0.0
    brighter_fatter: float = 0.0
    dual_conversion_ratio: float | None = None
    pixel_pitch_um: float = 1.4

    def system_gain_at(self, iso: float) -> float:
        """Return DN per electron at an ISO [DN/e-]."""
        return self.system_gain * iso / self.base_iso

    @property
    def knee(self) -> float:
        """Signal at which the higher of two amplifications ends [DN]."""
        return (self.white_level - max(self.black_level)) / (self.dual_conversion_ratio or 1.0)

    def dark_noise_at(
        self, iso: float, exposure_s: float, temperature_c: float | None = None, *, of_frames: bool = True
    ) -> float:
        """Return the temporal noise of a pixel in the dark before quantization [e-].

        Noise that rows, columns or the frame have in common is part of it: it moves a pixel from frame to frame as
        its own noise does.

        Parameters
        ----------
        iso
            ISO.
        exposure_s
            Exposure, for the shot noise of the dark current [s].
        temperature_c
            Temperature, likewise; None for that of the reference [deg C].
        of_frames
            Whether that of the frame is part of it: it is none of the spread within one frame.

        Examples
        --------
        >>> SensorParameters(
        ...     width=2,
        ...     height=2,
        ...     cfa="mono",
        ...     bit_depth=10,
        ...     black_level=(64.0,),
        ...     white_level=1023,
        ...     base_iso=100.0,
        ...     system_gain=0.5,
        ...     full_well=1e3,
        ...     response=(1.0,),
        ...     read_noise=3.0,
        ...     read_noise_post=2.0,
        ... ).dark_noise_at(100.0, 0.0)
        5.0

        """
        before = self.read_noise**2 + self.read_noise_row**2 + self.read_noise_column**2
        before += self.read_noise_frame**2 * of_frames
        before += self.rts_pixels * self.rts_amplitude**2
        after = self.read_noise_post / self.system_gain_at(iso) / (self.dual_conversion_ratio or 1.0)
        return math.sqrt(before + self.mean_dark_current(temperature_c) * exposure_s + after * after)

    def warmth(self, temperature_c: float | None) -> float:
        """Return how many times the dark current of the reference temperature flows at another [1]."""
        if temperature_c is None or self.dark_current_doubling_c is None:
            return 1.0
        return 2.0 ** ((temperature_c - self.dark_current_reference_c) / self.dark_current_doubling_c)

    def mean_dark_current(self, temperature_c: float | None = None) -> float:
        """Return the dark current of the mean pixel, hot ones included [e-/s]."""
        return (self.dark_current + self.hot_pixels * self.hot_pixel_current) * self.warmth(temperature_c)

    def saturation_at(self, iso: float, site: int = 0) -> float:
        """Return the charge at which a CFA site saturates: that of the full well or of the converter, if lower [e-].

        Parameters
        ----------
        iso
            ISO.
        site
            Position in the CFA cell, row-major.

        """
        converter = (self.white_level - self.black_level[site]) / self.system_gain_at(iso)
        return min(self.full_well, converter)

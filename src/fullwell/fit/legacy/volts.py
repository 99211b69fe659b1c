"""How the Pixel study turned DN into volts."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class VoltScale:
    """How the study turned DN into volts: swings rounded, over 2^bits in one place and over the white level in another.

    Parameters
    ----------
    swing_v
        Voltage swing [V].
    bit_depth, white_level
        Of the codes [bit], [DN].

    """

    swing_v: float
    bit_depth: int
    white_level: float

    @property
    def code_bits(self) -> int:
        """Return the bits of a code: those that the white level needs where files store 10 bits in 16 [bit]."""
        return min(self.bit_depth, int(self.white_level).bit_length())

    def read_noise_v(self, noise_dn: float) -> float:
        """Return read noise as the study's dv_to_v (.4591 / 1024) [V]."""
        return noise_dn * (round(self.swing_v, 4) / 2**self.code_bits)

    def level_v(self, level_dn: float) -> float:
        """Return a level or a slope as its scripts for the dark (.459 / 1023) [V]."""
        return level_dn * round(self.swing_v, 3) / self.white_level

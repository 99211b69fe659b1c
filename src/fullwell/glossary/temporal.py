"""Levels, temporal noise, dark current, photon transfer: what frames of a static scene tell."""

from typing import Final

from fullwell.glossary.entry import Quantity

_READ_NOISE_UNITS: Final = ("DN", "e-", "V")

LEVELS: Final = (
    Quantity(
        name="black_level",
        title="Black level",
        symbol="b",
        units=("DN",),
        definition="File offset: the mean raw value of a pixel that got no light, extrapolated to no exposure time.",
        equation="b = lim(t→0) mean of the dark frames",
        source="METHOD 2.3",
    ),
    Quantity(
        name="white_level",
        title="White level",
        symbol="w",
        units=("DN",),
        definition="Raw value at which the output saturates: the code where values pile up, else the declared level.",
        equation="w = highest code that holds a pile-up",
        source="METHOD 1.11",
    ),
    Quantity(
        name="digital_maximum",
        title="Digital maximum",
        symbol="D",
        units=("DN",),
        definition=(
            "Highest code of the converter, one for all channels, which the k's and volts are relative to: the "
            "declared white level, unless codes pile up above it or on a code of all ones. Pixels that are full before "
            "it do not lower it."
        ),
        equation="V = (x - b)/D",
        source="METHOD 0",
    ),
)

READ_NOISE: Final = (
    Quantity(
        name="read_noise",
        title="Read noise",
        symbol="σ_read",
        units=_READ_NOISE_UNITS,
        definition="Temporal noise of a pixel in the dark, analogue: the quantization of the converter is removed.",
        equation="σ_read = √(v̄ − q²/12), v̄ the mean over pixels of the variance over frames",
        source="METHOD 3.1",
        signed_twin=True,
    ),
    Quantity(
        name="read_noise_row",
        title="Temporal row noise",
        symbol="σ_tv",
        units=("DN", "e-"),
        definition="The part of the temporal dark noise that all pixels of a row share, new in each frame.",
        equation="σ²_tv = (MS_tv − MS_tvh)/N",
        source="METHOD 3.5",
        signed_twin=True,
    ),
    Quantity(
        name="read_noise_column",
        title="Temporal column noise",
        symbol="σ_th",
        units=("DN", "e-"),
        definition="The part of the temporal dark noise that all pixels of a column share, new in each frame.",
        equation="σ²_th = (MS_th − MS_tvh)/M",
        source="METHOD 3.5",
        signed_twin=True,
    ),
    Quantity(
        name="read_noise_excess",
        title="Scatter of the pixels' noise",
        symbol="ε",
        units=("1",),
        definition="Scatter over pixels of their variances, over what normal noise of one size gives: 1 without tails.",
        equation="ε = Var(v_ij)/(2σ⁴/(L−1))",
        source="METHOD 3.6",
    ),
    Quantity(
        name="read_noise_pre",
        title="Read noise before the amplifier",
        symbol="σ_pre",
        units=("DN", "e-"),
        definition="The part of the read noise that grows with the amplification, referred to amplification 1.",
        equation="σ²_read(g) = (σ_pre·g)² + σ_post²",
        source="METHOD 3.7",
        signed_twin=True,
    ),
    Quantity(
        name="read_noise_post",
        title="Read noise after the amplifier",
        symbol="σ_post",
        units=("DN",),
        definition="The part of the read noise that does not depend on the amplification.",
        equation="σ²_read(g) = (σ_pre·g)² + σ_post²",
        source="METHOD 3.7",
        signed_twin=True,
    ),
    Quantity(
        name="total_dark_noise",
        title="Total dark noise",
        symbol="σ_dark",
        units=("DN", "e-"),
        definition="Noise of one dark frame at a stated exposure: read noise, dark-current shot noise, fixed pattern.",
        equation="σ²_dark(t) = σ²_read + i·t + DSNU² + q²/12K²",
        source="METHOD 4.6",
        signed_twin=True,
    ),
)

DARK_CURRENT: Final = (
    Quantity(
        name="dark_current",
        title="Dark current",
        symbol="i",
        units=("DN/s", "e-/s", "V/s"),
        definition="Rate at which charge collects without light: the slope of the dark signal against exposure time.",
        equation="i = d(mean dark)/dt; from the variance i = (dσ²/dt)/K²",
        source="METHOD 4.1",
    ),
    Quantity(
        name="dark_current_doubling",
        title="Doubling of the dark current",
        symbol="T_d",
        units=("K",),
        definition="Rise of the temperature that doubles the dark current.",
        equation="i = i₀·2^((T − T₀)/T_d)",
        source="METHOD 4.5",
    ),
    Quantity(
        name="dark_current_resolution",
        title="Resolvable dark current",
        symbol="Δi",
        units=("DN/s", "e-/s"),
        definition="Smallest slope that this design of exposures and bursts can tell from zero at 95 % confidence.",
        equation="Δi = t₀.₉₇₅·SE(i)",
        source="METHOD 4.2",
    ),
)

PHOTON_TRANSFER: Final = (
    Quantity(
        name="system_gain",
        title="System gain",
        symbol="K",
        units=("DN/e-",),
        definition="Raw values per photo-electron; its inverse is the conversion factor in electrons per DN.",
        equation="σ² = A + K·S + C·S², S the signal above black",
        source="METHOD 1.4",
    ),
    Quantity(
        name="conversion_factor",
        title="Conversion factor",
        symbol="1/K",
        units=("e-/DN",),
        definition="Photo-electrons per raw value: the inverse of the system gain.",
        equation="1/K",
        source="EMVA1288 10.1",
    ),
    Quantity(
        name="k_dark",
        title="Dark-noise coefficient",
        symbol="k_Ndark",
        units=("1",),
        definition="Noise in the dark as a fraction of the largest signal.",
        equation="σ²(V) = k²_Ndark + k²_Nshot·V + k²_FPN·V², V = S/D",
        source="METHOD 0",
        signed_twin=True,
    ),
    Quantity(
        name="k_shot",
        title="Shot-noise coefficient",
        symbol="k_Nshot",
        units=("1",),
        definition="Photon shot noise at full signal as a fraction of it.",
        equation="σ²(V) = k²_Ndark + k²_Nshot·V + k²_FPN·V², V = S/D",
        source="METHOD 0",
        signed_twin=True,
    ),
    Quantity(
        name="k_fpn",
        title="Fixed-pattern coefficient",
        symbol="k_FPN",
        units=("1",),
        definition="Noise proportional to the signal; from a single frame an upper bound of the PRNU.",
        equation="σ²(V) = k²_Ndark + k²_Nshot·V + k²_FPN·V², V = S/D",
        source="METHOD 0",
        signed_twin=True,
    ),
    Quantity(
        name="channel_ratio",
        title="Channel ratio",
        symbol="r",
        units=("1",),
        definition="Signal of a colour channel relative to that of G1 under the same light.",
        equation="r = S_channel/S_G1",
        source="METHOD 1.10",
    ),
    Quantity(
        name="drift",
        title="Drift within a burst",
        symbol="Δ",
        units=("DN", "%", "DN/frame"),
        definition="How the mean of a frame moves over the frames of one series.",
        equation="slope or scatter of the frame means",
        source="METHOD 2.5",
    ),
)

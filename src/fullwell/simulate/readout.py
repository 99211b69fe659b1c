"""The way out: response curve, offsets and noise before the amplifier in electrons, amplification, noise after it."""

import numpy as np

from fullwell.kernels.random import normal
from fullwell.simulate.geometry import Stream
from fullwell.simulate.shot import FloatArray, Shot


def sensed(charge: FloatArray, shot: Shot) -> FloatArray:
    """Return the signal of the charge, bent by the response curve: Q (1 - e Q / full well) [e-].

    Parameters
    ----------
    charge
        Charge of each pixel [e-].
    shot
        What is taken.

    """
    sensor = shot.sensor
    if not sensor.nonlinearity:
        return charge
    return charge * (1.0 - sensor.nonlinearity / sensor.full_well * charge)


def read_out(charge: FloatArray, shot: Shot) -> FloatArray:
    """Return the signal before the amplifier: charge, fixed offsets, noise of pixel, row, column and frame [e-].

    Parameters
    ----------
    charge
        Signal of the charge of each pixel [e-].
    shot
        What is taken.

    """
    sensor, tile = shot.sensor, shot.tile
    rows, columns = tile.shape
    if sensor.read_noise:
        signal = normal(tile.shape, shot.draws(Stream.READ_NOISE))
        signal *= sensor.read_noise
        signal += charge
    else:
        signal = charge.copy()
    if sensor.read_noise_row:
        row_draws = shot.line_draws(Stream.READ_NOISE_ROW, tile.top)
        signal += sensor.read_noise_row * normal((1, rows), row_draws).T
    if sensor.read_noise_column:
        column_draws = shot.line_draws(Stream.READ_NOISE_COLUMN, tile.left)
        signal += sensor.read_noise_column * normal((1, columns), column_draws)
    if sensor.read_noise_frame:
        frame_draws = shot.line_draws(Stream.READ_NOISE_FRAME, 0)
        signal += sensor.read_noise_frame * normal((1, 1), frame_draws)
    return _jumped(_offset(signal, shot), shot)


def amplified(signal: FloatArray, shot: Shot) -> FloatArray:
    """Return the signal at the converter, without the black level [DN].

    Parameters
    ----------
    signal
        Signal before the amplifier [e-].
    shot
        What is taken.

    """
    sensor = shot.sensor
    signal *= sensor.system_gain_at(shot.exposure.iso)
    if not sensor.read_noise_post:
        return signal
    noise = normal(shot.tile.shape, shot.draws(Stream.READ_NOISE_POST))
    noise *= sensor.read_noise_post
    if sensor.dual_conversion_ratio:
        noise[signal < sensor.knee] /= sensor.dual_conversion_ratio
    noise += signal
    return noise


def _offset(signal: FloatArray, shot: Shot) -> FloatArray:
    """Add the fixed offsets of pixels, rows and columns [e-]."""
    sensor, individual, window = shot.sensor, shot.camera.individual, shot.tile.window
    if sensor.dsnu:
        signal += np.float32(sensor.dsnu) * individual.dsnu[window]
    if sensor.dsnu_row:
        signal += sensor.dsnu_row * individual.dsnu_row[window[0]]
    if sensor.dsnu_column:
        signal += sensor.dsnu_column * individual.dsnu_column[:, window[1]]
    return signal


def _jumped(signal: FloatArray, shot: Shot) -> FloatArray:
    """Add the level that each random-telegraph pixel is at, above or below its mean [e-]."""
    jumping = shot.camera.individual.jumping
    if jumping.size:
        above = normal(shot.tile.shape, shot.draws(Stream.RTS_STATE)) > 0.0
        signal += np.where(above, shot.sensor.rts_amplitude, -shot.sensor.rts_amplitude) * jumping[shot.tile.window]
    return signal

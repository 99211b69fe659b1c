"""The way out: response curve, offsets and noise before the amplifier in electrons, amplification, noise after it."""

import numpy as np

from fullwell.kernels.fixed_patterns import add_pattern
from fullwell.kernels.random import add_normal, normal
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
    sensor = shot.sensor
    if sensor.read_noise:
        add_normal(charge, sensor.read_noise, shot.draws(Stream.READ_NOISE))
    rows, columns = _row_offsets(shot), _column_offsets(shot)
    if sensor.dsnu:
        add_pattern(sensor.dsnu, shot.camera.individual.dsnu[shot.tile.window], rows, columns, charge)
    else:
        charge += rows[:, np.newaxis] + columns
    return _jumped(charge, shot)


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
    draws = shot.draws(Stream.READ_NOISE_POST)
    if sensor.dual_conversion_ratio:
        noise = normal(signal.shape, draws)
        noise *= sensor.read_noise_post
        noise[signal < sensor.knee] /= sensor.dual_conversion_ratio
        signal += noise
    else:
        add_normal(signal, sensor.read_noise_post, draws)
    return signal


def _row_offsets(shot: Shot) -> FloatArray:
    """Return what each row adds: its noise and its fixed offset, with the noise of the frame [e-]."""
    sensor, tile = shot.sensor, shot.tile
    offsets = np.zeros(tile.shape[0])
    if sensor.read_noise_frame:
        offsets += sensor.read_noise_frame * normal((1, 1), shot.line_draws(Stream.READ_NOISE_FRAME, 0))[0]
    if sensor.read_noise_row:
        draws = shot.line_draws(Stream.READ_NOISE_ROW, tile.top)
        offsets += sensor.read_noise_row * normal((1, offsets.size), draws)[0]
    if sensor.dsnu_row:
        offsets += sensor.dsnu_row * shot.camera.individual.dsnu_row[tile.window[0], 0]
    return offsets


def _column_offsets(shot: Shot) -> FloatArray:
    """Return what each column adds: its noise and its fixed offset [e-]."""
    sensor, tile = shot.sensor, shot.tile
    offsets = np.zeros(tile.shape[1])
    if sensor.read_noise_column:
        draws = shot.line_draws(Stream.READ_NOISE_COLUMN, tile.left)
        offsets += sensor.read_noise_column * normal((1, offsets.size), draws)[0]
    if sensor.dsnu_column:
        offsets += sensor.dsnu_column * shot.camera.individual.dsnu_column[0, tile.window[1]]
    return offsets


def _jumped(signal: FloatArray, shot: Shot) -> FloatArray:
    """Add the level that each random-telegraph pixel is at, above or below its mean [e-]."""
    jumping = shot.camera.individual.jumping
    if jumping.size:
        above = normal(shot.tile.shape, shot.draws(Stream.RTS_STATE)) > 0.0
        signal += np.where(above, shot.sensor.rts_amplitude, -shot.sensor.rts_amplitude) * jumping[shot.tile.window]
    return signal

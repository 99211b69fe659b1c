"""The way out: offsets and noise before the amplifier in electrons, amplification, noise after it in DN."""

from fullwell.kernels.random import normal
from fullwell.simulate.shot import FloatArray, Shot, Stream


def read_out(charge: FloatArray, shot: Shot) -> FloatArray:
    """Return the signal before the amplifier: charge, fixed offsets, noise of pixel, row, column and frame [e-].

    Parameters
    ----------
    charge
        Charge of each pixel [e-].
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
    if sensor.dsnu:
        signal += sensor.dsnu * shot.camera.dsnu[tile.window]
    if sensor.read_noise_row:
        row_draws = shot.line_draws(Stream.READ_NOISE_ROW, tile.top)
        signal += sensor.read_noise_row * normal((1, rows), row_draws).T
    if sensor.read_noise_column:
        column_draws = shot.line_draws(Stream.READ_NOISE_COLUMN, tile.left)
        signal += sensor.read_noise_column * normal((1, columns), column_draws)
    if sensor.read_noise_frame:
        frame_draws = shot.line_draws(Stream.READ_NOISE_FRAME, 0)
        signal += sensor.read_noise_frame * normal((1, 1), frame_draws)
    return signal


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
    system_gain = sensor.system_gain_at(shot.exposure.iso)
    if not sensor.read_noise_post:
        return signal * system_gain
    out = normal(shot.tile.shape, shot.draws(Stream.READ_NOISE_POST))
    out *= sensor.read_noise_post
    out += signal * system_gain
    return out

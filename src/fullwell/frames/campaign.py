"""What an EMVA 1288 datasheet says about camera, equipment and operation, beyond what frames tell."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Campaign:
    """The statements of the ``[emva]`` table; None where nobody made them.

    Parameters
    ----------
    vendor, model, serial_number
        Of the camera.
    company, date
        Who measured, and when (as written, 2026-05-04 for example).
    data_type, data_type_definition
        ``single``, ``typical``, ``guaranteed`` or ``guaranteed over lifetime``, and for how many samples, how selected.
    sensor_type, sensor_diagonal_mm, lens_category
        CMOS or CCD; diagonal [mm]; optical format [inch].
    readout_type, transfer_type
        Of a CCD.
    shutter_type, overlap_capabilities
        Of a CMOS sensor.
    maximum_readout_rate, dark_current_compensation, interface
        As the standard's basic information wants them.
    equipment, light_source, f_number, irradiance_measurement_error_percent, temperature_control
        Of the set-up; the error is that of the irradiance's measurement [%].
    frame_rate_hz, data_transfer_mode, gain_setting, environment_temperature_c, body_temperature_c
        Of the operation [Hz, degree Celsius].
    optional_parts
        Optional measurements that were made.

    """

    vendor: str | None = None
    model: str | None = None
    serial_number: str | None = None
    company: str | None = None
    date: str | None = None
    data_type: str | None = None
    data_type_definition: str | None = None
    sensor_type: str | None = None
    sensor_diagonal_mm: float | None = None
    lens_category: str | None = None
    readout_type: str | None = None
    transfer_type: str | None = None
    shutter_type: str | None = None
    overlap_capabilities: str | None = None
    maximum_readout_rate: str | None = None
    dark_current_compensation: str | None = None
    interface: str | None = None
    equipment: str | None = None
    light_source: str | None = None
    f_number: float | None = None
    irradiance_measurement_error_percent: float | None = None
    temperature_control: str | None = None
    frame_rate_hz: float | None = None
    data_transfer_mode: str | None = None
    gain_setting: str | None = None
    environment_temperature_c: float | None = None
    body_temperature_c: float | None = None
    optional_parts: str | None = None

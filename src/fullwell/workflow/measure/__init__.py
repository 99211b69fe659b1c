"""Statistics become rows: one module a measurement, each a pure function from bursts to a `Section`.

Order of the data: black level -> white level -> read noise, row and column noise -> dark current -> photon transfer
-> figures in electrons -> saturation, SNR, dynamic range -> every figure against ISO.
"""

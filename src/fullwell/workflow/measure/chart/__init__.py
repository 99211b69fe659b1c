"""Measurements on shots of test charts, one module each; `measure_shots` in `chart` runs them all."""

"""Public fixtures for tests: simulated studies of known truth."""

from fullwell.testing.studies import simulated_study, simulation

__all__ = ["simulated_study", "simulation"]

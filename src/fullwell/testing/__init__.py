"""Public fixtures: simulated sensors and hypothesis strategies."""

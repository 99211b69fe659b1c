"""Speed as ratios in one run: what Fullwell adds to the work that nobody can avoid."""

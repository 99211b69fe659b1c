"""THE table: every quantity with its symbol, units, equation, definition and source; report, docs and tests read it."""

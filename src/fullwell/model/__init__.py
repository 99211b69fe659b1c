"""How a sensor behaves: equations only, shared by the fits and the simulator."""

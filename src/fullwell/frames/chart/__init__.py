"""Test charts in a frame: which patches there are, where they lie, and what is known about them."""

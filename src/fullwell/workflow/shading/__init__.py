"""What is done with lens shading: maps fitted, compared, and scenes corrected by them."""

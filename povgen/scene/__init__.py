"""What is shown: parameters, what follows from them, movie specs and .pov text. May import `optics` and `settings`."""

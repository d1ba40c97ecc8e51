"""The teaching page around the live view. May import all but `measure`, `paper` and `cli`."""

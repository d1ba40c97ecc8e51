"""A module for each command, with a function `command`; what is slow to load, it loads when it runs."""

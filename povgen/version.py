"""The version of povgen."""

__version__ = "0.3.0"

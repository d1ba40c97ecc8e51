"""The version of povgen."""

__version__ = "0.1.0"

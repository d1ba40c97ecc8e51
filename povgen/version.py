"""The version of povgen."""

__version__ = "0.2.0"

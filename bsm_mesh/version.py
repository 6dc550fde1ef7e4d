"""The version of bsm-mesh."""

__version__ = "1.0.0"

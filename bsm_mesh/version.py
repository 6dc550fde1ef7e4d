"""The version of bsm-mesh."""

__version__ = "2.0.0"

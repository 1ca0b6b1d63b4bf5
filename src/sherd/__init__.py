"""Partial matching of non-rigid 3D shapes."""

__version__ = "0.1.0"

"""Rigid pieces: motions that neighborhoods vote for, fitted to the surface and judged there."""

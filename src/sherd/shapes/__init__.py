"""Floor 6: generated shapes and pieces of them, with exact ground truth."""

from __future__ import annotations

from sherd.shapes.creature import creature, landmarks
from sherd.shapes.fragment import Fragment, cut_by_ball, cut_by_plane, moved, remeshed, whole
from sherd.shapes.puzzle import puzzle_balls, puzzle_pieces

__all__ = [
    "Fragment",
    "creature",
    "cut_by_ball",
    "cut_by_plane",
    "landmarks",
    "moved",
    "puzzle_balls",
    "puzzle_pieces",
    "remeshed",
    "whole",
]

"""Counted nouns for messages: 1 face, 2 faces, 3 vertices."""

from __future__ import annotations

__all__ = ["counted", "spelled"]

_NOUNS = ("face", "edge", "vertex")


def counted(count: int, noun: str) -> str:
    """The count and the noun in singular or plural.

    Examples
    --------
    >>> counted(1, "vertex"), counted(0, "face")
    ('1 vertex', '0 faces')
    """
    if count == 1:
        return f"1 {noun}"
    return f"{count} vertices" if noun == "vertex" else f"{count} {noun}s"


def spelled(sentence: str, count: int) -> str:
    """`sentence` with the counted noun where {face}, {edge} or {vertex} stands.

    Examples
    --------
    >>> spelled("turned {face}", 2)
    'turned 2 faces'
    """
    return sentence.format(**{noun: counted(count, noun) for noun in _NOUNS})

"""Compiled: a binary heap that knows where its items stand, as Dijkstra's method needs.

`heap` holds items, smallest key first; `place` says where each item stands in it, -1 if nowhere.
"""

from __future__ import annotations

from sherd.compiled import compiled

__all__ = ["lower", "pop"]


@compiled()
def pop(heap, place, keys, filled):
    """The item of the smallest key, taken out of a heap of `filled` entries."""
    item = heap[0]
    place[item] = -1
    if filled > 1:
        _sink(heap, place, keys, heap[filled - 1], filled - 1)
    return item


@compiled()
def lower(heap, place, keys, item, filled):
    """Put an item, new or with a smaller key than before, where it belongs; entries then."""
    if place[item] < 0:
        place[item] = filled
        filled += 1
    _rise(heap, place, keys, item)
    return filled


@compiled()
def _rise(heap, place, keys, item):
    """Move `item`, at its place in the heap, up to where it belongs."""
    at = place[item]
    while at > 0:
        above = (at - 1) // 2
        if keys[heap[above]] <= keys[item]:
            break
        heap[at] = heap[above]
        place[heap[at]] = at
        at = above
    heap[at] = item
    place[item] = at


@compiled()
def _sink(heap, place, keys, item, filled):
    """Put `item` at the top of a heap of `filled` entries and move it down."""
    at = 0
    while 2 * at + 1 < filled:
        below = 2 * at + 1
        if below + 1 < filled and keys[heap[below + 1]] < keys[heap[below]]:
            below += 1
        if keys[item] <= keys[heap[below]]:
            break
        heap[at] = heap[below]
        place[heap[at]] = at
        at = below
    heap[at] = item
    place[item] = at

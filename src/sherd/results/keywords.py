"""Options given as an object or as keywords: one of the two, and only names that exist."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import TYPE_CHECKING, Any, TypeVar

from sherd.errors import OptionError

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

__all__ = ["options_of"]

Options = TypeVar("Options", bound="DataclassInstance")


def options_of(
    kind: type[Options], options: Options | None, keywords: Mapping[str, Any]
) -> Options:
    """The options that were given either way; the defaults if none were.

    Raises
    ------
    OptionError
        If a keyword is unknown, both ways are used at once, or `options` is of another kind.
    """
    known = [each.name for each in fields(kind)]
    for name in keywords:
        if name not in known:
            raise OptionError(f"{name!r} is no option; known are {', '.join(known)}")
    if options is None:
        return kind(**keywords)
    if not isinstance(options, kind):
        raise OptionError(f"options is a {type(options).__name__}, but takes {kind.__name__}")
    if keywords:
        given = ", ".join(f"{name}=..." for name in keywords)
        raise OptionError(
            f"options and {given} are both given; write all into {kind.__name__}(...), or all as "
            "keywords"
        )
    return options

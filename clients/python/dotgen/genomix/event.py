"""The names that scripts of genomix import from `genomix.event`."""

from __future__ import annotations

import enum

from ..protocol import Error

__all__ = ["GenoMError", "Status"]

#: Base of all errors, under its name in genomix.
GenoMError = Error


class Status(str, enum.Enum):
    """The status of a request. Each is equal to its name."""

    sent = "sent"
    done = "done"
    error = "error"

    def __str__(self) -> str:
        return self.value

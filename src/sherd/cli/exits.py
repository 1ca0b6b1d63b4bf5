"""Exit codes: one place that turns what happened into a number and one line of text."""

from __future__ import annotations

import os
import signal
import sys
import threading
from typing import Any, NoReturn

import click

from sherd.errors import InputError, OptionError, OutputError, SherdError

__all__ = [
    "INTERNAL",
    "INTERRUPTED",
    "INVALID_INPUT",
    "NOT_CONVERGED",
    "NOT_WRITTEN",
    "SOME_FAILED",
    "USAGE",
    "ReportingGroup",
]

USAGE = 2
INVALID_INPUT = 3
NOT_CONVERGED = 4
NOT_WRITTEN = 5
SOME_FAILED = 6  # of many questions, some have no answer
INTERNAL = 70  # EX_SOFTWARE of sysexits.h
INTERRUPTED = 130  # 128 + SIGINT


class ReportingGroup(click.Group):
    """A group of commands whose errors end in one line on standard error and an exit code."""

    def main(self, *args: Any, **kwargs: Any) -> Any:
        """Run a command and exit; see the module for the codes."""
        kwargs["standalone_mode"] = False
        try:
            result = super().main(*args, **kwargs)
        except click.exceptions.Exit as done:
            sys.exit(done.exit_code)
        except click.ClickException as error:
            error.show()
            sys.exit(error.exit_code)
        except (click.Abort, KeyboardInterrupt):
            _leave_interrupted()
        except SherdError as error:
            _say(str(error))
            sys.exit(_code(error))
        except MemoryError:
            _say("not enough memory; decimate the meshes first, for example to 100,000 vertices")
            sys.exit(INVALID_INPUT)
        except BrokenPipeError:
            # the reader of our output has gone; Python would complain while closing the stream
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            sys.exit(0)
        except Exception as error:
            if _was_interrupted(error):
                _leave_interrupted()
            if os.environ.get("SHERD_DEBUG"):
                raise
            _say(
                f"internal error: {type(error).__name__}: {error}; please report it "
                "(SHERD_DEBUG=1 shows where it happened)"
            )
            sys.exit(INTERNAL)
        sys.exit(result if isinstance(result, int) else 0)


def _was_interrupted(error: BaseException) -> bool:
    """Whether an error stands for Ctrl-C: where that ends compiled code it has one of its own."""
    cause = error.__cause__ or error.__context__
    return isinstance(error, KeyboardInterrupt) or (cause is not None and _was_interrupted(cause))


def _leave_interrupted() -> NoReturn:
    _when_interrupted_again(signal.SIG_IGN)
    _say("interrupted; nothing was left half-written")
    _when_interrupted_again(_leave_at_once)
    sys.exit(INTERRUPTED)


def _when_interrupted_again(handler: Any) -> None:
    """While leaving, Python waits for its threads; a second Ctrl-C shall not end in a traceback."""
    if threading.current_thread() is threading.main_thread():  # others cannot handle signals
        signal.signal(signal.SIGINT, handler)


def _leave_at_once(*_: object) -> None:
    os._exit(INTERRUPTED)  # what was begun has been taken back: there is nothing to wait for


def _code(error: SherdError) -> int:
    if isinstance(error, OptionError):
        return USAGE
    if isinstance(error, OutputError):
        return NOT_WRITTEN
    if isinstance(error, InputError):
        return INVALID_INPUT
    return INTERNAL


def _say(text: str) -> None:
    one_line = " ".join(text.split())
    click.echo(f"{click.style('sherd:', fg='red', bold=True)} {one_line}", err=True)

"""One run of a command-line program and its exit status."""

import os
import sys
from collections.abc import Sequence

from cyclopts import App, CycloptsError

from footnav.cli.console import print_error
from footnav.errors import ConfigError, FootnavError

FAILED, MISUSED, INTERRUPTED = 1, 2, 130


def run_app(app: App, arguments: Sequence[str]) -> int:
    """Run the command that the arguments name; errors are printed in one line each.

    Parameters
    ----------
    app : App
        The program.
    arguments : sequence of str
        Arguments after the program's name.

    Returns
    -------
    int
        Exit status: 0 done, 1 the data or the run failed, 2 misuse, 130 interrupted.
    """
    try:
        return _run(app, arguments)
    except CycloptsError as error:
        chain = error.command_chain or ()
        print_error(f"{error} See: {' '.join((*app.name, *chain))} --help")
        return MISUSED
    except ConfigError as error:
        print_error(error)
        return MISUSED
    except FootnavError as error:
        print_error(error)
        return FAILED
    except BrokenPipeError:
        # The reader of a pipe, such as `head`, has closed it; without this the interpreter
        # reports the error again at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return FAILED
    except KeyboardInterrupt:
        print_error("interrupted")
        return INTERRUPTED


def _run(app: App, arguments: Sequence[str]) -> int:
    command, bound, _ = app.parse_args(arguments, exit_on_error=False, print_error=False)
    status: int | None = command(*bound.args, **bound.kwargs)
    sys.stdout.flush()
    return status or 0

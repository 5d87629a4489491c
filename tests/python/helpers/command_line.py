"""The command line in this process."""

from collections.abc import Callable
from dataclasses import dataclass

import pytest

from footnav.cli import main


@dataclass(frozen=True)
class CommandResult:
    """Status and output of a command."""

    status: int
    out: str
    err: str


Run = Callable[..., CommandResult]


def run_in_process(capsys: pytest.CaptureFixture[str], *arguments: object) -> CommandResult:
    """Run a command of footnav."""
    status = main([str(argument) for argument in arguments])
    return CommandResult(status, *capsys.readouterr())

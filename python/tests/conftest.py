"""Programs that the tests need."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

Simulate = Callable[..., str]


@pytest.fixture
def simulate() -> Iterator[Simulate]:
    """Starts ``profivac simulate`` and returns what it prints after ``ready``. ``PROFIVAC`` is the path of the program."""
    program = os.environ.get("PROFIVAC")
    if program is None:
        pytest.skip("PROFIVAC is not set to the path of the program")
    with ExitStack() as stack:

        def start(*arguments: str | Path) -> str:
            command = [program, "simulate", *map(str, arguments)]
            process = stack.enter_context(subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True))
            stack.callback(process.terminate)
            assert process.stdout is not None
            word, _, place = process.stdout.readline().strip().partition(" ")
            assert word == "ready", word
            return place

        yield start

"""What is being done, while it is done."""

from __future__ import annotations

import sys
from collections.abc import Callable
from types import TracebackType
from typing import Any

#: Whether, or to whom, progress is told.
Progress = bool | Callable[[str], Any] | None


class Teller:
    """Tells what is being done: to a function, or in one line of a terminal or notebook, cleared at the end."""

    def __init__(self, progress: Progress) -> None:
        self._shown: Any = None
        self.tell: Callable[[str], Any] | None = None
        if callable(progress):
            self.tell = progress
        elif progress is not False and _in_notebook():
            self.tell = self._display
        elif progress or (progress is None and _in_terminal()):
            self.tell = self._line

    def __enter__(self) -> Callable[[str], Any] | None:
        return self.tell

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._shown is None:
            return
        if self.tell == self._display:
            self._shown.update({"text/plain": ""}, raw=True)
        else:
            print("\r\x1b[2K", end="", file=sys.stderr, flush=True)

    def _line(self, doing: str) -> None:
        self._shown = doing
        print(f"\r\x1b[2K{doing}", end="", file=sys.stderr, flush=True)

    def _display(self, doing: str) -> None:
        from IPython.display import display  # type: ignore

        text = {"text/plain": doing}
        if self._shown is None:
            self._shown = display(text, raw=True, display_id=True)
        else:
            self._shown.update(text, raw=True)


def _in_terminal() -> bool:
    return sys.stderr is not None and sys.stderr.isatty()


def _in_notebook() -> bool:
    """Whether a notebook's kernel runs this: none is imported that is not there yet."""
    interactive = sys.modules.get("IPython")
    shell = interactive.get_ipython() if interactive is not None else None
    return getattr(shell, "kernel", None) is not None

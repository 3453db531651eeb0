"""FMUs are evaluated by interpreters that do nothing else: what crashes there ends none of ours."""

from __future__ import annotations

import sys
from pathlib import Path

from . import _lacuna


def name_this_interpreter() -> None:
    """Say that this interpreter evaluates FMUs, called again."""
    beside = str(Path(__file__).resolve().parent.parent)
    # Modules in the folder it is called in are none of ours.
    code = (
        f"import sys; sys.path.pop(0); sys.path.append({beside!r}); "
        "from lacuna import _lacuna; _lacuna.evaluate_fmu(sys.argv[1])"
    )
    _lacuna.evaluate_fmus_with(sys.executable, ["-c", code])

"""Pieces of a model file."""

from __future__ import annotations

import json
import re
from typing import Any


def quoted(text: str) -> str:
    """A text as TOML has it, which JSON has likewise."""
    return json.dumps(text, ensure_ascii=False)


def said(**entries: str) -> list[str]:
    """Entries, a line each."""
    return [f"{key} = {quoted(text)}" for key, text in entries.items()]


def parameter(name: str, value: float, unit: str, tolerance: float | None, std: float | None) -> str:
    """A line of ``[parameters]``."""
    sure = f", std = {float(std)!r}" if std is not None else ""
    sure += f", tolerance = {float(tolerance)!r}" if tolerance is not None else ""
    key = name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else quoted(name)
    return f"{key} = {{ value = {float(value)!r}, unit = {quoted(unit)}{sure} }}"


def recordings(described: dict[str, Any]) -> list[str]:
    """What recordings hold: their column of time, what inputs do between samples, what is measured."""
    lines = ["[recordings]", *said(time=described["time"], input_hold=described["input_hold"])]
    for column, of, unit in described["measurements"]:
        lines += ["[[measurement]]", *said(column=column, of=of, unit=unit)]
    return lines

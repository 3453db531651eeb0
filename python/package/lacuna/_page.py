"""Pages in notebooks."""

from __future__ import annotations

import html


def framed(page: str, title: str) -> str:
    """A page in a frame of its own, where neither its style nor that of the notebook reaches the other."""
    # What leads to a part of the page would lead to the notebook: without a base, addresses begin at that of the page
    # that the frame is in.
    based = page.replace("<head>", '<head><base href="about:srcdoc">', 1)
    held = html.escape(based, quote=True)
    style = "width: 100%; height: 48em; border: none"
    return f'<iframe srcdoc="{held}" style="{style}" title="{html.escape(title, quote=True)}"></iframe>'

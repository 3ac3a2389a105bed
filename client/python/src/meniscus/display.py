# SPDX-License-Identifier: BSD-3-Clause
"""How values look in a notebook. Whatever a case or a daemon says is text, never HTML."""

from __future__ import annotations

from html import escape
from typing import Any, Iterable, Sequence


def table(rows: Iterable[Sequence[Any]], head: Sequence[str] = ()) -> str:
    """Rows of cells below a head."""
    top = "".join(f"<th>{escape(str(cell))}</th>" for cell in head)
    body = "".join(
        "<tr>" + "".join(f'<td style="text-align:left">{escape(str(cell))}</td>' for cell in row) + "</tr>" for row in rows
    )
    return f"<table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>" if top else f"<table>{body}</table>"


def bar(fraction: float) -> str:
    """How far it is, 0 to 1."""
    return f'<progress max="1" value="{min(1.0, max(0.0, fraction)):.4f}"></progress>'

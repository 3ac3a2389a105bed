# SPDX-License-Identifier: BSD-3-Clause
"""Texts that come from outside, in sentences for people."""

from __future__ import annotations

import unicodedata

_HIDDEN = ("Cc", "Cf", "Cs", "Zl", "Zp")  # control, format, half of a pair, ends of lines


def shown(text: object) -> str:
    """What a terminal would obey, or would not show, as \\t or \\uXXXX; the ends of lines stay."""
    return "".join(c.encode("unicode_escape").decode() if c != "\n" and unicodedata.category(c) in _HIDDEN else c for c in str(text))

#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""manual.py BUILD PAGE...: manual pages as BUILD/man/PAGE, from what the programs in BUILD say of themselves, the READMEs of clients and
dashboard and the manual of the case format. Nothing is said here that is said there."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

CLIENTS = Path(__file__).resolve().parents[1] / "README.md"
DASHBOARD = CLIENTS.parent / "dashboard" / "README.md"


def escape(text: str) -> str:
    """Text as it is, for roff."""
    text = text.replace("\\", "\\e").replace("-", "\\-").replace("`", "\\(ga").replace("^", "\\(ha").replace("~", "\\(ti")
    text = text.replace("'", "\\(aq").replace('"', "\\(dq")
    return "".join(c if ord(c) < 128 else f"\\[u{ord(c):04X}]" for c in text)


def guard(line: str) -> str:
    """A line of text that begins with a dot is no request."""
    return "\\&" + line if line.startswith((".", "'")) else line


def inline(text: str) -> str:
    """Markdown within a line: code is bold, what is stressed is in italics, links are their words."""
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", text)
    parts = []
    for part in re.split(r"(`[^`]+`|\*[^*\s][^*]*\*)", text):
        if len(part) > 2 and part[0] == part[-1] == "`":
            parts.append(f"\\fB{escape(part[1:-1])}\\fR")
        elif len(part) > 2 and part[0] == part[-1] == "*":
            parts.append(f"\\fI{escape(part[1:-1])}\\fR")
        else:
            parts.append(escape(part))
    return "".join(parts)


def literal(lines: list[str]) -> list[str]:
    return [".PP", ".RS 4", ".nf", *(guard(escape(line)) for line in lines), ".fi", ".RE"]


def table(rows: list[str]) -> list[str]:
    """Each row is an item; what its other cells are is said by the head of the table, but for the last, which explains."""
    cells = [[cell.strip().replace("\\|", "|") for cell in re.split(r"(?<!\\)\|", row.strip()[1:-1])] for row in rows]
    head, out = cells[0], []
    for row in cells[2:]:
        facts = [f"{name}: {cell}" for name, cell in zip(head[1:-1], row[1:-1]) if cell]
        text = "; ".join(facts) + (". " if facts else "") + row[-1]
        out += [".TP", guard(inline(row[0])), guard(inline(text)) or "\\&"]
    return out


def is_end(line: str) -> bool:
    """Does a paragraph or an item end before this line?"""
    return not line.strip() or line.startswith(("- ", "|", "```", "#"))


def markdown(text: str) -> list[str]:
    """The Markdown that our manuals are written in: headings, paragraphs, lists, tables, fences."""
    out: list[str] = []
    lines, k = text.splitlines(), 0
    while k < len(lines):
        line = lines[k]
        if line.startswith("```"):
            end = next(n for n in range(k + 1, len(lines)) if lines[n].startswith("```"))
            out += literal(lines[k + 1:end])
            k = end
        elif heading := re.match(r"(#+) (.*)", line):
            if len(heading[1]) > 1:
                kind = ".SH" if len(heading[1]) == 2 else ".SS"
                out.append(f'{kind} {inline(heading[2].upper() if kind == ".SH" else heading[2])}')
        elif line.startswith("|"):
            end = next((n for n in range(k, len(lines)) if not lines[n].startswith("|")), len(lines))
            out += table(lines[k:end])
            k = end - 1
        elif line.startswith("    ") and (k == 0 or not lines[k - 1].strip()):
            end = next((n for n in range(k, len(lines)) if not lines[n].startswith("    ")), len(lines))
            out += literal([row[4:] for row in lines[k:end]])
            k = end - 1
        elif line.strip():
            is_item = line.startswith("- ")
            end = next((n for n in range(k + 1, len(lines)) if is_end(lines[n])), len(lines))
            text_of = " ".join(row.strip() for row in lines[k:end])
            out += [".IP \\(bu 2" if is_item else ".PP", guard(inline(text_of[2:] if is_item else text_of))]
            k = end - 1
        k += 1
    return without_empty_paragraphs(out)


def without_empty_paragraphs(lines: list[str]) -> list[str]:
    """A heading begins a paragraph by itself."""
    return [line for k, line in enumerate(lines) if not (line == ".PP" and k and lines[k - 1].startswith((".SH", ".SS")))]


def sections(text: str, *names: str) -> str:
    """Of a README those sections, in its words."""
    parts = re.split(r"(?m)^(?=## )", text)
    return "".join(part for part in parts if part.startswith(tuple(f"## {name}\n" for name in names)))


def explained(text: str) -> list[str]:
    """Help as programs print it: lines that begin with a blank are examples."""
    out: list[str] = []
    examples: list[str] = []
    for line in [*text.splitlines(), ""]:
        if line.startswith(" "):
            examples.append(line.strip())
            continue
        if examples:
            out += literal(examples)
            examples = []
            if line:
                out.append(".PP")
        if line:
            out.append(guard(inline(line)))
    return out


def options(table_of: list[dict]) -> list[str]:
    out = []
    for option in table_of:
        names = ([f"\\fB{escape('-' + option['letter'])}\\fR"] if option["letter"] else []) + [
            f"\\fB{escape('--' + option['name'])}\\fR"
        ]
        value = f" \\fI{escape(option['value'])}\\fR" if option["value"] else ""
        out += [".TP", ", ".join(names) + value, guard(inline(option["help"]))]
    return out


def title(name: str, section: int, version: str, about: str) -> list[str]:
    return [
        '.\\" Generated. SPDX-License-Identifier: BSD-3-Clause',
        f'.TH {name.upper()} {section} "" "Meniscus {version}" "Meniscus"',
        ".nh",
        ".SH NAME",
        f"{escape(name)} \\- {escape(about)}",
    ]


def see(*pages: str) -> list[str]:
    return [".SH SEE ALSO", *(f".BR {escape(p[:-3])} {p[-3:]}{',' if p != pages[-1] else ''}" for p in pages)]


def lower(sentence: str) -> str:
    return sentence[0].lower() + sentence[1:].rstrip(".")


def client_page(tables: dict) -> list[str]:
    out = title("meniscus", 1, tables["version"], lower(tables["about"]))
    out += [".SH SYNOPSIS", ".B meniscus", "\\fICOMMAND\\fR [\\fIOPTION\\fR]... [\\fIWORD\\fR]...", ".SH DESCRIPTION"]
    out += explained(tables["beginning"]) + [".SH COMMANDS"]
    for command in tables["commands"]:
        if command["group"]:
            out.append(f".SS {escape(command['group'])}")
        arguments = f" \\fI{escape(command['arguments'])}\\fR" if command["arguments"] else ""
        help_text = command["help"]
        out += [".TP", f"\\fB{escape(command['name'])}\\fR{arguments}", guard(inline(help_text[0].upper() + help_text[1:])) + "."]
        inner = ([".PP", *explained(command["details"])] if command["details"] else []) + options(command["options"])
        if inner:
            out += [".RS", *(inner[1:] if inner[:2] == [".PP", ".PP"] else inner), ".RE"]
    out += [".SH OPTIONS", "Of every command that talks to a daemon:", *options(tables["options"])]
    out += [".SH EXIT STATUS"]
    for row in tables["exit_codes"]:
        out += [".TP", f".B {row['code']}", guard(inline(row["meaning"]))]
    out += markdown(sections(CLIENTS.read_text(encoding="utf-8"), "For scripts", "Connections"))
    return out + see("meniscusd(8)", "meniscus-case(5)")


def program_page(name: str, section: int, version: str, text: str) -> list[str]:
    """From the help that a program prints: two columns, of which the first may overflow into lines of its own."""
    before, after = text.split("\n\n", 1)
    about = " ".join(before.splitlines()[1:])
    out = title(name, section, version, lower(about))
    out += [".SH SYNOPSIS", f".B {escape(name)}", "[\\fIOPTION\\fR]...", ".SH OPTIONS"]
    body, _, ending = after.partition("\n\nMandatory")
    item: list[str] = []
    items = [item]
    for line in body.splitlines():
        if re.match(r" {2,6}-", line):
            names, _, rest = line.strip().partition("  ")
            item = [names, rest.strip()]
            items.append(item)
        elif line.strip() and item:
            item[1] += " " + line.strip()
    for names, meaning in items[1:]:
        bold = re.sub(r"(--?[\w?-]+)(?:(\[?=)(.*))?", bold_option, names)
        out += [".TP", bold, guard(inline(meaning.strip()))]
    exits = [part for part in ending.split("\n\n") if part.startswith("Exit codes:")]
    if exits:
        out += [".SH EXIT STATUS", guard(inline(" ".join(exits[0].split()).partition(": ")[2]))]
    return out


def bold_option(match: "re.Match[str]") -> str:
    value = f"{escape(match[2])}\\fI{escape(match[3])}\\fR" if match[2] else ""
    return f"\\fB{escape(match[1])}\\fR{value}"


def case_page(text: str, version: str) -> list[str]:
    out = title("meniscus-case", 5, version, "the case file")
    return out + [".SH DESCRIPTION", *markdown(text)] + see("meniscus(1)", "meniscusd(8)")


def main() -> None:
    build, names = Path(sys.argv[1]), sys.argv[2:]
    environment = {**os.environ, "LC_ALL": "C", "ARGP_HELP_FMT": "rmargin=100"}

    def said(*words: str) -> str:
        return subprocess.run(
            [str((build / words[0]).resolve()), *words[1:]], env=environment, capture_output=True, text=True, check=True
        ).stdout

    tables = json.loads(said("meniscus", "help", "-o", "json"))
    version = tables["version"]

    def daemon_page() -> list[str]:
        return program_page("meniscusd", 8, version, said("meniscusd", "--help")) + see("meniscus(1)", "meniscus-case(5)")

    def dashboard_page() -> list[str]:
        page = program_page("meniscus-dashboard", 8, version, said("meniscus-dashboard", "--help"))
        readme = DASHBOARD.read_text(encoding="utf-8")
        return page + markdown(sections(readme, "What it costs", "Who may")) + see("meniscus(1)", "meniscusd(8)")

    pages = {
        "meniscus.1": lambda: client_page(tables),
        "meniscusd.8": daemon_page,
        "meniscus-dashboard.8": dashboard_page,
        "meniscus-case.5": lambda: case_page((build / "case-reference.md").read_text(encoding="utf-8"), version),
    }
    for name in names:
        (build / "man" / name).write_text("\n".join(pages[name]()) + "\n", encoding="utf-8")


main()

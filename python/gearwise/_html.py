"""Answers in notebooks: plain HTML without script; all text is escaped."""

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Sequence


def escaped(text: object) -> str:
    """Text that stands safely in HTML; what turns the direction of reading is shown as a mark."""
    out = str(text)
    for sign, safe in (("&", "&amp;"), ("<", "&lt;"), (">", "&gt;"), ('"', "&quot;"), ("'", "&#39;")):
        out = out.replace(sign, safe)
    turns = "\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069\u200e\u200f\u061c"
    return "".join("\ufffd" if c in turns or (ord(c) < 32 and c not in "\n\t") else c for c in out)


def cell(value: object) -> str:
    """A cell: numbers short, what is not known as a dash."""
    if value is None or value != value:
        return "–"
    return f"{value:.4g}" if isinstance(value, float) else escaped(value)


def table_html(names: "Sequence[str]", rows: "Sequence[Sequence[object]]", of: int) -> str:
    """A table of the first rows, and how many there are."""
    # Columns of which the shown rows say nothing are left out.
    shown = [k for k in range(len(names)) if any(cell(row[k]) not in ("–", "") for row in rows)][:14]
    head = "".join(f"<th>{escaped(names[k])}</th>" for k in shown)
    body = "".join("<tr>" + "".join(f"<td>{cell(row[k])}</td>" for k in shown) + "</tr>" for row in rows)
    more = f"<p>{len(rows)} of {of} rows</p>" if of > len(rows) else ""
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>{more}"

"""The table of agreement: one row a check, in Markdown."""

from dataclasses import dataclass

HEAD = ("case", "ours", "theirs", "difference", "limit", "pass")


@dataclass(frozen=True)
class Row:
    """One check. `difference` and `limit` are in the words of the check; `passed` decides."""

    case: str
    ours: str
    theirs: str
    difference: str
    limit: str
    passed: bool

    @classmethod
    def of(cls, case: str, ours: str, theirs: str, difference: float, limit: float, unit: str = "") -> "Row":
        """A check that a number is not above its limit; a NaN is."""
        return cls(case, ours, theirs, f"{difference:.1e}{unit}", f"{limit:g}{unit}", bool(difference <= limit))


def markdown(rows: list[Row]) -> str:
    lines = ["| " + " | ".join(HEAD) + " |", "|---|---|---|--:|--:|---|"]
    for row in rows:
        cells = (row.case, row.ours, row.theirs, row.difference, row.limit, "yes" if row.passed else "**NO**")
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)

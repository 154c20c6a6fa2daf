"""docs/papers.md from the catalog and what its commands printed."""

from catalog import VERDICTS, Catalog, CatalogError, Row


def figures(row: Row, measured: dict[str, dict[str, str]]) -> str:
    """What the row found, with the figures of its last run."""
    found = measured.get(row.name, {})
    missing = [name for name, _ in row.find if name not in found]
    if missing:
        raise CatalogError(f"{row.name} was not run: {', '.join(missing)} (tools/papers/papers.py {row.name})")
    return row.ours.format_map(found)


def cells(row: Row, measured: dict[str, dict[str, str]]) -> str:
    """A line of the table."""
    columns = [row.item, row.theirs, figures(row, measured), VERDICTS[row.verdict]]
    return "| " + " | ".join(columns) + " |"


def block(rows: list[Row]) -> str:
    """The commands of a table, each row's below its item; those of rows with the same commands stand once."""
    items: dict[tuple[str, ...], list[str]] = {}
    for row in rows:
        if row.commands:
            items.setdefault(row.commands, []).append(row.item)
    parts = ["\n".join([f"# {'; '.join(names)}", *commands]) for commands, names in items.items()]
    return "```sh\n" + "\n\n".join(parts) + "\n```"


def page(catalog: Catalog, measured: dict[str, dict[str, str]]) -> str:
    """The whole page."""
    parts = [catalog.head.strip()]
    for name, (title, deviations) in catalog.papers.items():
        rows = [row for row in catalog.rows if row.paper == name]
        lines = ["| item | the paper | pellucid | |", "|---|---|---|---|", *(cells(row, measured) for row in rows)]
        parts += [f"## {title}", "\n".join(lines), block(rows), deviations.strip()]
    return "\n\n".join(parts) + "\n"

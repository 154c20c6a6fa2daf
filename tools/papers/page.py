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
    commands = "<br>".join(f"`{command}`" for command in row.commands)
    columns = [row.item, row.theirs, figures(row, measured), VERDICTS[row.verdict], commands]
    return "| " + " | ".join(column.replace("\n", " ").strip() for column in columns) + " |"


def page(catalog: Catalog, measured: dict[str, dict[str, str]]) -> str:
    """The whole page."""
    parts = [catalog.head.strip()]
    for name, (title, deviations) in catalog.papers.items():
        lines = [cells(row, measured) for row in catalog.rows if row.paper == name]
        table = "\n".join(["| item | the paper | pellucid | | command |", "|---|---|---|---|---|", *lines])
        parts += [f"## {title}", table, deviations.strip()]
    return "\n\n".join(parts) + "\n"

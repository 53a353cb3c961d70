"""The reference of the robot file, from the JSON Schema that `tauten schema` prints."""

from __future__ import annotations

import json
from typing import Any

from tauten.service.file_schema import robot_file_schema

LONGEST_LIST = 3  # names of tables in a cell; more are given as "a region"
HEAD = """\
# Robot file

A robot is a TOML file, and the files of its meshes and networks of beams. Written from the schema that
`tauten schema` prints; with that schema an editor completes fields and shows errors while one types:

```sh
tauten schema > tauten.schema.json
```

and as the first line of the robot file `#:schema tauten.schema.json`.

All values are in SI units, but for the mesh file itself, whose unit `length_unit` names. A bad value is
refused with one sentence that names the file, the field, what was found and what is allowed.
"""


def robot_file_page() -> str:
    """All tables of a robot file with their fields."""
    schema = robot_file_schema()
    tables: dict[str, Any] = schema["$defs"]
    lines = [HEAD]
    roots = [item["$ref"].rsplit("/", 1)[-1] for item in schema["anyOf"]]
    shown: list[str] = []
    for root in roots:
        title = tables[root]["description"].rstrip(".")
        lines += [f"## {title}", "", *fields(tables[root]), ""]
        waiting = references(tables[root])
        while waiting:
            name = waiting.pop(0)
            if name in shown or name in roots:
                continue
            shown.append(name)
            lines += [f"({name.lower()})=", f"### {heading(name)}", ""]
            lines += [" ".join(tables[name].get("description", "").split()), ""]
            lines += [*fields(tables[name]), ""]
            waiting = references(tables[name]) + waiting
    return "\n".join(lines)


def heading(name: str) -> str:
    """Name of a table as a heading: the words of a class without "Settings"."""
    words = "".join(
        f" {letter.lower()}" if letter.isupper() else letter
        for letter in name.removesuffix("Settings").removesuffix("Table")
    )
    return words.strip().capitalize()


def references(part: Any) -> list[str]:
    """Names of the tables that a part of the schema refers to, in order."""
    if isinstance(part, dict):
        found = [part["$ref"].rsplit("/", 1)[-1]] if "$ref" in part else []
        return found + [name for value in part.values() for name in references(value)]
    if isinstance(part, list):
        return [name for value in part for name in references(value)]
    return []


def fields(table: dict[str, Any]) -> list[str]:
    """Rows of a Markdown table, one a field."""
    needed = table.get("required", [])
    rows = ["| field | value | default | |", "| :-- | :-- | :-- | :-- |"]
    for name, field in table.get("properties", {}).items():
        default = "needed" if name in needed else shown_default(field.get("default"))
        text = " ".join(field.get("description", "").split()).replace("|", "\\|")
        rows.append(f"| `{name}` | {value_of(field)} | {default} | {text} |")
    return rows if len(rows) > 2 else []


def shown_default(value: Any) -> str:
    """A default as TOML shows it."""
    if value is None or isinstance(value, dict) or value == []:
        return "none" if value is None else ""
    return f"`{json.dumps(value, ensure_ascii=False)}`"


def value_of(field: dict[str, Any]) -> str:
    """What a field may hold, in words."""
    if "$ref" in field:
        name = field["$ref"].rsplit("/", 1)[-1]
        return f"[{heading(name).lower()}](#{name.lower()})"
    if "const" in field:
        return f"`{field['const']}`"
    if "enum" in field:
        return ", ".join(f"`{value}`" for value in field["enum"])
    for key in ("anyOf", "oneOf", "allOf"):
        if key in field:
            parts = [part for part in field[key] if part.get("type") != "null"]
            if len(parts) > LONGEST_LIST:
                return "a region: its name or a table"
            return " or ".join(dict.fromkeys(value_of(part) for part in parts))
    if field.get("type") == "array":
        if "prefixItems" in field:
            kinds = list(dict.fromkeys(value_of(part) for part in field["prefixItems"]))
            return f"{len(field['prefixItems'])} times {' / '.join(kinds)}"
        return f"list of {value_of(field.get('items', {}))}"
    if field.get("type") in ("number", "integer"):
        return bounded(field)
    return {"string": "text", "boolean": "true, false"}.get(field.get("type", ""), "table")


def bounded(field: dict[str, Any]) -> str:
    """A number with its bounds."""
    words = [field["type"]]
    for key, sign in (
        ("exclusiveMinimum", ">"),
        ("minimum", "≥"),
        ("exclusiveMaximum", "<"),
        ("maximum", "≤"),
    ):
        if key in field:
            words.append(f"{sign} {field[key]:g}")
    return f"{words[0]} {', '.join(words[1:])}".strip()

"""`python -m benchmarks first-hour`: README's first command after its installation."""

from __future__ import annotations

from tauten.service.cli.terminal import Json, Markdown, progress_bar, show_result


def first_hour(json_file: Json = None, markdown: Markdown = None) -> None:
    """Time the demo: nothing compiled, with the kernels that are shipped, and a second time."""
    from benchmarks.tables import first_hour_page
    from tauten.service.kernels import first_demos

    with progress_bar("demo") as report:
        found = first_demos(report)
    show_result(found, first_hour_page(found), json_file, markdown)

"""`python -m tauten.service` is the `tauten` command."""

from tauten.service.cli import main

main()

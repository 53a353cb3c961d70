"""`python -m benchmarks NAME …` runs a benchmark."""

from benchmarks.commands import app
from tauten.service.cli import run

run(app)

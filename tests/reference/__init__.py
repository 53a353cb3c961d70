"""Answers to QPCCs by other programs, against which the solver is tested."""

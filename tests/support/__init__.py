"""What several tests share: small robots, commands as processes, faults, checks of solutions."""

"""Drivers of hardware: their interface, and the loop between a node and a driver."""

from tauten.service.drive.driver import Driver, DriverError, Measured, make_driver
from tauten.service.drive.loop import drive, run_driver

__all__ = ["Driver", "DriverError", "Measured", "drive", "make_driver", "run_driver"]

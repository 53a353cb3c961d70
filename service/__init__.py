"""The service: time, messages and files around the controller."""

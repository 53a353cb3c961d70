"""What the robot is: finite elements, cables, contacts, and the forward simulator."""

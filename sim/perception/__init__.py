"""What the robot knows of the world: sensors, touch, and the symbolic state grounded in them."""

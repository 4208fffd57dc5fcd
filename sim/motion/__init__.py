"""Motion of the arm: tool paths, inverse kinematics and collision checks."""

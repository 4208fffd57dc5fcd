"""Motion of the arm: tool paths, inverse kinematics, motion planning and time parameterisation."""

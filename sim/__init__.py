"""A Franka Panda in MuJoCo that carries plans out."""

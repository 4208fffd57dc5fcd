"""Robots of MuJoCo Menagerie, fetched once with git and given what a scene needs of a robot."""

"""Robots of MuJoCo Menagerie, downloaded once with git and adapted for scenes."""

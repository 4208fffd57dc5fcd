"""The commands of `prefplan`: one command, one file of its name, loaded when it is called.

Each file has a function of its name, decorated by `experiments.cli.command.command`, which imports its libraries
when it is called: help, shell completion and wrong calls wait for no library.
"""

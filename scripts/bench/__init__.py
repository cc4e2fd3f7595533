"""The subcommands of scripts/bench.py.

A module of this package that has the functions add_arguments(parser) and run(arguments) is a subcommand; there is no
list of them. Its name is the module's NAME or, without one, its file's name; its docstring is its help. The other
modules are what the subcommands share.
"""

"""python -m drench: the command `drench`."""

from .command import main

main()

"""What can go wrong through no fault of the program."""


class InputError(ValueError):
    """Something that the user gave cannot be: the message names it, its value and what is allowed."""


class PovrayError(RuntimeError):
    """POV-Ray is missing, failed, was killed or took too long: the message tells which, and where."""

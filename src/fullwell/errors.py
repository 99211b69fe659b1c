"""What can go wrong when Fullwell is used.

::

    FullwellError
    |-- UsageError         bad use: an option, a path, a manifest (exit status 2)
    `-- RawFileError       one file cannot be read or must not be measured; a study turns it into a finding
        |-- UnreadableFileError    truncated, damaged, or not what its name says
        `-- UnsuitableFileError    readable, but lossy, processed or otherwise unfit for noise work

Every message is a sentence that says what is wrong and what to do about it.
"""


def why(error: Exception) -> str:
    """Return why something could not be read, in the system's words, without its number for it and the path."""
    return error.strerror if isinstance(error, OSError) and error.strerror else str(error)


def system_refusal(error: OSError) -> str | None:
    """Return in a sentence what the system refused, and where; None where it was not the system that did."""
    if error.filename is None and error.errno is None:
        return None
    where = "" if error.filename is None else f" {error.filename}"
    return f"The system refused{where}: {error.strerror}."


class FullwellError(Exception):
    """Base of every error Fullwell raises on purpose."""


class UsageError(FullwellError):
    """Bad use: the sentence says what to do instead."""


class RawFileError(FullwellError):
    """One file cannot be used.

    Parameters
    ----------
    code
        Stable identifier of the reason, for example ``"file-truncated"``; it becomes the code of a finding.
    message
        A sentence for people, without the file's name.

    """

    def __init__(self, code: str, message: str) -> None:
        super().__init__(message)
        self.code = code
        self.message = message


class UnreadableFileError(RawFileError):
    """The file is truncated, damaged, or not what its name says."""


class UnsuitableFileError(RawFileError):
    """The file can be read but is lossy, processed or otherwise unfit for noise measurements."""

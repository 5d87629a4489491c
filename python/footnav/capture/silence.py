"""How long a source has been looked at in vain."""


class Silence:
    """Counts from the first look that found nothing, so that a host that did not look does not count as silence."""

    def __init__(self) -> None:
        self._since: float | None = None

    def end(self) -> None:
        """Forget the silence: something came."""
        self._since = None

    def last(self, now: float) -> float:
        """Return how long it has lasted at `now`, s; it begins with the first call."""
        if self._since is None:
            self._since = now
        return now - self._since

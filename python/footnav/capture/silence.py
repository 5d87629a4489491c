"""How long a source has been looked at in vain."""

_LONGEST_LOOK = 0.25
"""s; a host that did not look for longer, because it was busy or stopped, cannot tell silence from its own absence."""


class Silence:
    """Adds up the times between looks that found nothing."""

    def __init__(self) -> None:
        self._last: float | None = None
        self._total = 0.0

    def end(self) -> None:
        """Forget the silence: something came."""
        self._last, self._total = None, 0.0

    def grow(self, now: float) -> float:
        """Count a look at `now` that found nothing, and return how long the silence has lasted, s."""
        if self._last is not None:
            self._total += min(now - self._last, _LONGEST_LOOK)
        self._last = now
        return self._total

"""How long a source has sent no sample: a question of the link, not of motion."""

_MAX_POLL_INTERVAL = 0.25
"""s; a host that polls later was busy or suspended, and the samples of that time may be lost."""


class Silence:
    """Adds up the times between polls without a sample."""

    def __init__(self) -> None:
        self._last: float | None = None
        self._total = 0.0

    def reset(self) -> None:
        """Start again after a sample."""
        self._last, self._total = None, 0.0

    def update(self, now: float) -> float:
        """Add a poll at time `now`, s, without a sample; return the length of the silence, s."""
        if self._last is not None:
            self._total += min(now - self._last, _MAX_POLL_INTERVAL)
        self._last = now
        return self._total

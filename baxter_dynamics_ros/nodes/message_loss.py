"""Number of messages lost by the middleware, from sequence numbers."""


class MessageLoss:
    """
    Counts gaps in the sequence numbers of a subscription's publishers.

    rclpy does not report the publisher of a message, so each number is attributed to the publisher
    whose last number it follows most closely. The middleware's own message-lost event does not
    count messages that a full queue replaces.
    """

    def __init__(self) -> None:
        self.lost = 0  # number of messages
        self._last: list[int] = []  # sequence number of each publisher's newest message
        self._new = 0  # publishers that have matched but not sent anything yet

    def matched(self, change: int) -> None:
        """Process a change in the total number of matched publishers."""
        self._new += change

    def received(self, number: int | None) -> None:
        """Process the sequence number of a message; None if the middleware provides none."""
        if number is None:
            return
        before = [last for last in self._last if last < number]
        if before and (max(before) == number - 1 or not self._new):
            self._last.remove(max(before))
            self.lost += number - 1 - max(before)
        else:
            self._new = max(self._new - 1, 0)
        self._last = [*self._last, number][-16:]  # publishers come and go

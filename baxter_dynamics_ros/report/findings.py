"""Findings: sentences that rules derive from results."""

from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

from ..model.joints import JOINTS


class Finding(NamedTuple):
    """One thing to know."""

    topic: str
    text: str


Rules = Sequence[tuple[str, Callable[[Any], 'str | None']]]


def findings(rules: Rules, of: Any) -> list[Finding]:
    """Return what rules (topic, function of the results) find."""
    found = ((topic, rule(of)) for topic, rule in rules)
    return [Finding(topic, text) for topic, text in found if text]


def listed(where: Iterable[Any], texts: Sequence[str] = JOINTS) -> str:
    """Return the joints for which a condition holds, or their texts."""
    return ', '.join(text for text, holds in zip(texts, where) if holds)

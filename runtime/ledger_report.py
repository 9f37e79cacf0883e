"""The books, as every report.json shows them."""

from typing import Any

from echogrid.mapping.ledger import Ledger


def account(ledger: Ledger, waiting: int) -> dict[str, Any]:
    """The books, as a report holds them."""
    return {
        "readings": ledger.produced,
        "outcomes": dict(sorted(ledger.outcomes.items())),
        "fused": ledger.fused,
        "dropped": dict(sorted(ledger.dropped.items())),
        "waiting": waiting,
        "balances": ledger.balances(waiting),
    }

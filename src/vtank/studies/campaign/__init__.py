"""Campaigns: many runs from one file, flown in chunks on threads, processes or a cluster, and kept as one data set.

campaign = load_campaign("paper-noise")
fly_campaign(campaign, Path("out"), Threads(2))
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...facade import facade

if TYPE_CHECKING:
    from .campaign import Campaign
    from .executors import Cluster, Executor, LocalCluster, Processes, Threads
    from .flying import Tally, fly_campaign
    from .loading import load_campaign

__all__ = facade(__name__)

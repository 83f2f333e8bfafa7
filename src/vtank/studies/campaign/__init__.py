"""Campaigns: many runs from one file, flown in chunks on threads, processes or a cluster, and kept as one data set.

campaign = load_campaign("paper-noise")
fly_campaign(campaign, Path("out"), Threads(2))
"""

from __future__ import annotations

from .campaign import Campaign
from .executors import Cluster, Executor, LocalCluster, Processes, Threads
from .flying import Tally, fly_campaign
from .loading import load_campaign

__all__ = [
    "Campaign",
    "Cluster",
    "Executor",
    "LocalCluster",
    "Processes",
    "Tally",
    "Threads",
    "fly_campaign",
    "load_campaign",
]

"""Phrases of the pages that are computed from the results kept in docs/results."""

from phrases import (
    arms,
    clouds,
    contact,
    coverage,
    guidance,
    interfaces,
    network,
    organs,
    paper,
    planning,
    registration,
    stability,
    tissue,
    wall,
)

TIES = [
    *(paper.TIES + wall.TIES + stability.TIES + guidance.TIES + planning.TIES + registration.TIES),
    *(coverage.TIES + contact.TIES + organs.TIES + arms.TIES + clouds.TIES + tissue.TIES + interfaces.TIES),
    *network.TIES,
]

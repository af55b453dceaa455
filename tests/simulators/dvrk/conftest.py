"""A simulated dVRK for tests: it runs for a time, homes its arms and collects events."""

import pytest

from palpate.simulators import dvrk


class Robot:
    """A system that keeps its events."""

    def __init__(self, *arms, **options):
        self.system = dvrk.system(arms, **options)
        self.events = []
        self.send, self.state, self.teleop = self.system.send, self.system.state, self.system.teleop

    def run(self, seconds):
        """Run for `seconds` in whole ticks; returns the events of this time."""
        self.system.step(max(round(seconds / self.system.tick), 1))
        news = self.system.events()
        self.events += news
        return news

    def home(self, *arms):
        """Power and home arms; all arms by default."""
        for arm in arms or self.system.arms:
            self.send(arm, "state_command", "home")
        for _ in range(12):
            self.run(1.0)
            if all(self.state(a)["is_homed"] and not self.state(a)["is_busy"] for a in arms or self.system.arms):
                return self
        raise AssertionError([e for e in self.events if e[2] in ("warning", "error")])

    def messages(self, kind, news=None):
        """Texts of the events status, warning or error."""
        return [e[3] for e in (self.events if news is None else news) if e[2] == kind]


@pytest.fixture
def robot():
    return Robot

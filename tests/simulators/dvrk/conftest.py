"""A simulated dVRK and what tests ask of it: run for seconds, home, collect what was said."""

import pytest

from palpate.simulators import dvrk


class Robot:
    """A system with its events kept."""

    def __init__(self, *arms, **options):
        self.system = dvrk.system(arms, **options)
        self.said = []
        self.send, self.state, self.teleop = self.system.send, self.system.state, self.system.teleop

    def run(self, seconds):
        """So long, in whole ticks; the events it brought."""
        self.system.step(max(round(seconds / self.system.tick), 1))
        news = self.system.events()
        self.said += news
        return news

    def home(self, *arms):
        """Power and home arms (all when none is named)."""
        for arm in arms or self.system.arms:
            self.send(arm, "state_command", "home")
        for _ in range(12):
            self.run(1.0)
            if all(self.state(a)["is_homed"] and not self.state(a)["is_busy"] for a in arms or self.system.arms):
                return self
        raise AssertionError([e for e in self.said if e[2] in ("warning", "error")])

    def words(self, kind, news=None):
        """Texts of status, warning or error."""
        return [e[3] for e in (self.said if news is None else news) if e[2] == kind]


@pytest.fixture
def robot():
    return Robot

"""A short run of `palpate fuzz haply`, and proof that its judges can fail."""

import numpy as np
import pytest

from palpate_lab.verify.fuzz import FaultError, haply


def test_damaged_messages_of_haplys_service():
    total: dict[str, int] = {}
    for seed in range(20):
        for name, n in haply.case(seed).items():
            total[name] = total.get(name, 0) + n
    assert total["messages"] == 2000
    assert min(total["states accepted"], total["states refused"], total["events of ours"], total["other events"]) > 50


class Planted:
    """A reader with a mistake."""

    def __init__(self, change):
        self._reader, self._change = haply._reader(), change

    def read(self, text):
        return self._change(self._reader.read(text))


@pytest.mark.parametrize(
    ("change", "words"),
    [(lambda found: None, "a sound message was refused"),
     (lambda found: found and ([0.0, *found[0][1:]], *found[1:]), "was read, not"),
     (lambda found: found or ([0.0] * 3, [0.0] * 3), "Python does not find")],
)  # fmt: skip
def test_planted_mistakes_of_the_reader_are_found(change, words):
    rng = np.random.default_rng(0)
    sound = haply._state(rng)
    reader = Planted(change)

    def judge():
        haply._judge_state(reader, sound, True)
        haply._judge_state(reader, b'{"inverse3": []}', False)

    with pytest.raises(FaultError, match=words):
        judge()


def test_a_planted_mistake_of_the_frames_is_found(monkeypatch):
    pytest.importorskip("websockets")
    monkeypatch.setattr(haply, "_expected", lambda data: [b"other"])
    with pytest.raises(FaultError, match="1 by websockets"):
        haply._judge_frames(haply._frame(0x81, b"one"))

"""Words for invalid values of the files that people write: the message for one of pydantic's errors."""

from palpate.base.values.wording.keys import place_in_file
from palpate.base.values.wording.message import describe

__all__ = ["describe", "place_in_file"]

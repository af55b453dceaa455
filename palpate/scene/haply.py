"""Options of the driver of Haply devices in a scene: ``driver: {haply: {id: 04C3}}``."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, ValidationError

from palpate.base.errors import DeviceError
from palpate.base.values import NotNegative, Section

_TEXTS = ("id", "url", "grip")  # options that are no numbers


class HaplySection(Section):
    """A Haply Inverse3 or Minverse behind the vendor's Inverse Service (docs/haply.md)."""

    id: str | None = None
    """id of the device, as Haply Hub shows it; needed where the service knows several"""
    url: str = "ws://127.0.0.1:10001"
    """address of the service"""
    grip: str | None = None
    """id of the grip that gives orientation and buttons; `none`: without; when left out, the first that is awake"""
    rate: Annotated[float, Field(ge=50.0, le=10000.0)] = 2000.0
    """messages per second, which is the rate of the haptic cycle [Hz]"""
    force_max: Annotated[float, Field(gt=0.0, le=20.0)] = 3.0
    """largest force; the vendor publishes no limit [N]"""
    gravity: Annotated[NotNegative, Field(le=2.0)] | None = 1.0
    """scaling of the device's gravity compensation, 0: off; null: left as it is [-]"""
    damping: NotNegative = 0.0
    """scalar of the service's damping filter, from service 3.5 on [-]"""
    force_gate: NotNegative | None = None
    """gain of the service's force gate, from service 3.5 on; as it is when left out [-]"""

    @classmethod
    def from_text(cls, text: str) -> HaplySection:
        """The options of ``haply:id=04C3,url=ws://127.0.0.1:10001``.

        Raises:
            DeviceError: there is no such option, or its value is invalid.
        """
        try:
            pairs = (part.split("=", 1) for part in text.split(",") if part)
            given = {key: _value(key, value) for key, value in pairs}
        except ValueError as error:
            what = f"the options {text!r} of the driver haply cannot be read"
            raise DeviceError(what, why=str(error), mend="write e.g. haply:id=04C3,rate=1000") from None
        try:
            return cls.validated(given)
        except ValidationError as error:
            first = error.errors()[0]
            what = f"driver haply: {'.'.join(map(str, first['loc']))}: {first['msg']}"
            raise DeviceError(what, mend=f"its options are {', '.join(cls.model_fields)} (docs/haply.md)") from None

    def to_text(self) -> str:
        """The name of the driver with its options, as `from_text` reads them."""
        given = self.model_dump(exclude_unset=True)
        said = {key: value for key, value in given.items() if value is not None or key == "gravity"}
        text = ",".join(f"{key}={'none' if value is None else value}" for key, value in said.items())
        return f"haply:{text}" if text else "haply"


def _value(key: str, text: str) -> str | float | None:
    """An option as its text states it; gravity=none leaves the gravity compensation as it is."""
    if key == "gravity" and text == "none":
        return None
    return text if key in _TEXTS else float(text)

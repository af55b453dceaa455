"""Lists the imperfections of a simulated run, so that the reader knows how realistic the simulation is."""

from __future__ import annotations

from html import escape

from palpate.arm import hands
from palpate.base.errors import PalpateError
from palpate.record.reader import Record
from palpate.scene.scene import Scene
from palpate.session.recorded import recorded_scene

_WORDS = (
    "Arm, hand and follower are simulated with these imperfections of real devices. Each has a key in the scene file. "
    "Where it is off, the simulation is ideal."
)


def imperfections(scene: Scene) -> list[tuple[str, str, bool]]:
    """(imperfection, size, whether on) of a scene, including those that are off."""
    leader, hand, rate = scene.arms.leader, scene.operator, scene.rates.haptic
    rows = [
        ("sampling", f"a cycle every {1e3 / rate:.3g} ms; the torque is constant in between", True),
        ("loop delay", _ms(scene.loop_delay) + ", of the force's torque", scene.loop_delay > 0),
        ("loop jitter", f"0 to {_ms(scene.loop_jitter)} more, random in each cycle", scene.loop_jitter > 0),
        ("encoders", _encoders(scene), leader.quantised and (leader.encoder_scale > 0 or bool(leader.encoder_step))),
        ("velocity estimate", _velocity(scene), leader.quantised),
        ("drive lag", f"{_ms(leader.drive_lag)} of first order, of all torque", leader.drive_lag > 0),
        ("drive torque limits", f"{leader.drive_limit_scale:g} times the limits that the controller assumes", True),
        ("dry friction", f"{leader.coulomb_scale:g} times the arm's", leader.coulomb_scale > 0),
        ("load cell noise", f"{leader.load_cell_noise:g} N rms per axis", leader.load_cell_noise > 0),
        ("controller's mass error", f"{leader.model_mass_scale:g} times the true masses", leader.model_mass_scale != 1),
        ("follower servo", f"bandwidth {scene.arms.follower.bandwidth:g} Hz", scene.arms.follower.bandwidth > 0),
        ("hand", _hand(scene), True),
        ("tremor", f"{1e3 * hand.tremor:g} mm rms, 8 to 12 Hz", hand.tremor > 0),
        ("grip", f"slips above {hand.grip_force_max:g} N", True),
    ]
    return [(what, words if on else "none", on) for what, words, on in rows]


def section(record: Record) -> str:
    """The imperfections as a section of the report; empty when the record holds no scene."""
    try:
        rows = imperfections(recorded_scene(record))
    except PalpateError:
        return ""
    body = "".join(
        f'<tr><td>{escape(what)}</td><td class="value">{"on" if on else "off"}</td><td>{escape(words)}</td></tr>'
        for what, words, on in rows
    )
    return f'<section><h2>Imperfections</h2><p>{_WORDS}</p><table class="facts-table">{body}</table></section>'


def _ms(seconds: float) -> str:
    return f"{1e3 * seconds:.3g} ms"


def _encoders(scene: Scene) -> str:
    leader = scene.arms.leader
    if leader.encoder_step is not None:
        size = "counts of " + ", ".join(f"{leader.encoder_scale * s:.3g}" for s in leader.encoder_step)
        return f"{size} rad (or m)"
    return f"counts of {leader.encoder_scale:g} times the hardware's"


def _velocity(scene: Scene) -> str:
    leader = scene.arms.leader
    how = "from the time between counts" if leader.velocity == "edges" else "from counts one haptic cycle apart"
    return how + (f", low-passed at {leader.velocity_cutoff:g} Hz" if leader.velocity_cutoff > 0 else "")


def _hand(scene: Scene) -> str:
    o = scene.operator
    known = hands.PRESETS.get(o.hand)
    same = known is None or (known.mass, known.damping, known.stiffness) == (o.mass, o.damping, o.stiffness)
    return f"{o.hand if same else 'own'}: {o.mass:g} kg, {o.damping:g} N s/m, {o.stiffness:g} N/m to its intended path"
